// What the tests under a real systemd need and no program of the system does:
//   device_helper freeze PID THREAD   stops the thread of that name until the process ends: a hang that the program
//                                     itself has no part in
//   device_helper probe               tries what a sandbox should forbid or allow; a line "what: ok" or "what: ERRNO"
//   each
#include <dirent.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace {

/// The thread's id; 0 if there is none of that name.
pid_t FindThread(const std::string& pid, const std::string& name) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + pid + "/task")) {
    std::string comm;
    std::getline(std::ifstream(entry.path() / "comm"), comm);
    if (comm == name) return std::atoi(entry.path().filename().c_str());
  }
  return 0;
}

int Freeze(const std::string& pid, const std::string& name) {
  const pid_t thread = FindThread(pid, name);
  if (thread == 0) {
    std::fprintf(stderr, "device_helper: process %s has no thread %s\n", pid.c_str(), name.c_str());
    return 1;
  }
  if (ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0 || ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) {
    std::perror("device_helper: ptrace");
    return 1;
  }
  std::printf("frozen\n");
  std::fflush(stdout);
  // The first report is that it has stopped, and it stays so; the last that it is gone.
  int status = 0;
  while (waitpid(thread, &status, __WALL) == thread && !WIFEXITED(status) && !WIFSIGNALED(status)) {
  }
  return 0;
}

/// @param result of a system call.
void Tell(const std::string& what, long result) {
  const int error = errno;
  std::printf("%s: %s\n", what.c_str(), result >= 0 ? "ok" : strerrorname_np(error));
}

void TryToWrite(const std::string& file) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  Tell("write " + file, fd);
  if (fd >= 0) unlink(file.c_str());
}

void TryToSend(const char* name, in_addr_t address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(7667);
  to.sin_addr.s_addr = htonl(address);
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  Tell(std::string("send to ") + name, sendto(fd, "x", 1, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to));
}

void TellWho() {
  std::array<gid_t, 64> groups{};
  const int count = getgroups(static_cast<int>(groups.size()), groups.data());
  const bool video =
      std::find(groups.begin(), groups.begin() + std::max(count, 0), 44) != groups.begin() + std::max(count, 0);
  std::printf("root: %s\nvideo: %s\n", geteuid() == 0 ? "yes" : "no", video ? "yes" : "no");
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("CapEff") || line.starts_with("NoNewPrivs") || line.starts_with("Seccomp:"))
      std::printf("%s\n", line.c_str());
}

int Probe() {
  TellWho();
  TryToWrite("/etc/probe");
  TryToWrite("/usr/lib/probe");
  if (const char* state = std::getenv("STATE_DIRECTORY")) TryToWrite(std::string(state) + "/probe");
  if (const char* runtime = std::getenv("RUNTIME_DIRECTORY")) TryToWrite(std::string(runtime) + "/probe");
  Tell("read /root", open("/root", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  Tell("see process 1", access("/proc/1", F_OK));
  Tell("socket AF_INET", socket(AF_INET, SOCK_DGRAM, 0));
  Tell("socket AF_PACKET", socket(AF_PACKET, SOCK_DGRAM, 0));
  TryToSend("239.255.76.67", 0xEFFF4C43);
  TryToSend("127.0.0.1", INADDR_LOOPBACK);
  TryToSend("192.0.2.1", 0xC0000201);
  Tell("open /dev/null", open("/dev/null", O_WRONLY | O_CLOEXEC));
  Tell("open /dev/probe", open("/dev/probe", O_WRONLY | O_CLOEXEC));
  sched_param parameter{};
  parameter.sched_priority = 1;
  Tell("SCHED_FIFO", sched_setscheduler(0, SCHED_FIFO, &parameter));
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(static_cast<unsigned>(sched_getcpu()), &cpus);
  Tell("pin", sched_setaffinity(0, sizeof cpus, &cpus));
  void* memory = mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  Tell("writable code", memory == MAP_FAILED ? -1 : 0);
  Tell("mount namespace", unshare(CLONE_NEWNS));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string task = argc > 1 ? argv[1] : "";
  if (task == "freeze" && argc == 4) return Freeze(argv[2], argv[3]);
  if (task == "probe" && argc == 2) return Probe();
  std::fprintf(stderr, "usage: device_helper freeze PID THREAD | device_helper probe\n");
  return 2;
}
