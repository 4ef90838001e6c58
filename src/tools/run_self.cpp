#include "tools/run_self.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <string_view>
#include <system_error>

namespace chequer {
namespace {

/// The parent lets Ctrl-C pass while a child has the terminal.
class IgnoreInterrupt {
 public:
  IgnoreInterrupt() : old_(std::signal(SIGINT, SIG_IGN)) {}
  ~IgnoreInterrupt() { std::signal(SIGINT, old_); }
  IgnoreInterrupt(const IgnoreInterrupt&) = delete;
  IgnoreInterrupt& operator=(const IgnoreInterrupt&) = delete;

 private:
  void (*old_)(int);
};

int Spawn(const char* file, const std::string& name, const std::vector<std::string>& arguments, bool in_path) {
  std::vector<std::string> words{name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  const IgnoreInterrupt here;
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t restored;
  sigemptyset(&restored);
  sigaddset(&restored, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &restored);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int wrong = (in_path ? posix_spawnp : posix_spawn)(&child, file, nullptr, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (wrong != 0) throw std::system_error(wrong, std::generic_category(), name);
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), name);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

int RunSelf(const std::vector<std::string>& arguments) { return Spawn("/proc/self/exe", "chequer", arguments, false); }

int RunProgram(const std::string& program, const std::vector<std::string>& arguments) {
  return Spawn(program.c_str(), program, arguments, true);
}

std::string ShellText(const std::string& program, const std::vector<std::string>& arguments) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_./:=,+@";
  std::string text = program;
  for (const std::string& word : arguments) {
    text += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
      text += word;
      continue;
    }
    text += '\'';
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += '\'';
  }
  return text;
}

}  // namespace chequer
