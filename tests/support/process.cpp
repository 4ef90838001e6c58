#include "support/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>

namespace chequer::test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

[[noreturn]] void Fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

milliseconds Until(Clock::time_point deadline) {
  return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(deadline - Clock::now()));
}

}  // namespace

Process::Process(std::vector<std::string> arguments, const std::vector<std::string>& environment) {
  std::vector<std::string> all_environment(environment);
  for (char** variable = environ; *variable != nullptr; ++variable) all_environment.emplace_back(*variable);
  std::vector<char*> argv = Pointers(arguments);
  std::vector<char*> envp = Pointers(all_environment);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) Fail("pipe2");
  pipe_ = UniqueFd(ends[0]);
  const UniqueFd write_end(ends[1]);
  const UniqueFd nothing(open("/dev/null", O_RDONLY | O_CLOEXEC));
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) Fail("fork");
  if (pid_ == 0) {
    // A test that crashes or is killed leaves nothing running.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);
    dup2(nothing.get(), STDIN_FILENO);
    dup2(write_end.get(), STDOUT_FILENO);
    dup2(write_end.get(), STDERR_FILENO);
    execvpe(argv[0], argv.data(), envp.data());
    _exit(127);
  }
  end_ = UniqueFd(static_cast<int>(syscall(SYS_pidfd_open, pid_, 0)));
  if (!end_.valid()) Fail("pidfd_open");
}

Process::~Process() {
  if (status_) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool Process::Read(milliseconds timeout) {
  pollfd waiting{pipe_.get(), POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(timeout.count())) <= 0) return true;
  std::array<char, 4096> bytes{};
  const ssize_t count = read(pipe_.get(), bytes.data(), bytes.size());
  if (count <= 0) return false;
  output_.append(bytes.data(), static_cast<std::size_t>(count));
  return true;
}

bool Process::WaitForOutput(const std::string& text, milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (output_.find(text) == std::string::npos)
    if (!Read(Until(deadline)) || Clock::now() >= deadline) return output_.find(text) != std::string::npos;
  return true;
}

void Process::Signal(int number) const { kill(pid_, number); }

std::optional<int> Process::Wait(milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  bool reads = true;
  while (!status_) {
    // Its output is read all the while: a full pipe would keep it from ending.
    std::array<pollfd, 2> waiting{{{end_.get(), POLLIN, 0}, {reads ? pipe_.get() : -1, POLLIN, 0}}};
    if (poll(waiting.data(), waiting.size(), static_cast<int>(Until(deadline).count())) <= 0) return std::nullopt;
    if (waiting[1].revents != 0) reads = Read(milliseconds(0));
    if (waiting[0].revents == 0) continue;
    int status = 0;
    waitpid(pid_, &status, 0);
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    output();
  }
  return status_;
}

const std::string& Process::output() {
  for (bool reads = true; reads;) {
    const std::size_t before = output_.size();
    reads = Read(milliseconds(0)) && output_.size() > before;
  }
  return output_;
}

RunResult RunToEnd(std::vector<std::string> arguments) {
  Process process(std::move(arguments));
  const int status = process.Wait(std::chrono::minutes(1)).value_or(-1);
  return {status, process.output()};
}

}  // namespace chequer::test
