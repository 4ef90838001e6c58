#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/unique_fd.h"

namespace chequer::test {

/// A program that a test runs; its standard output and error come together, its input is empty. Killed if it still runs
/// at the end, or when the thread that started it ends.
class Process {
 public:
  /// @param arguments the program's path first. @param environment "NAME=value", added to the test's own.
  explicit Process(std::vector<std::string> arguments, const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Waits until what it has printed contains a text; false when the time is over or it has ended without.
  bool WaitForOutput(const std::string& text, std::chrono::milliseconds timeout = std::chrono::seconds(60));

  void Signal(int number) const;
  pid_t pid() const { return pid_; }
  /// Its exit status, or 128 + the signal that ended it; nothing if it did not end in time.
  std::optional<int> Wait(std::chrono::milliseconds timeout = std::chrono::seconds(60));

  /// All it has printed so far; complete after Wait.
  const std::string& output();
  bool IsRunning() { return !Wait(std::chrono::milliseconds(0)); }

 private:
  /// Reads what is there, waiting for it at most that long; false at the end of the output.
  bool Read(std::chrono::milliseconds timeout);

  pid_t pid_ = -1;
  UniqueFd end_;  ///< a descriptor of the process, readable when it has ended
  UniqueFd pipe_;
  std::string output_;
  std::optional<int> status_;
};

/// What a program that has ended leaves.
struct RunResult {
  int status = -1;  ///< its exit status, or 128 + the signal that ended it; -1 if it did not end in time
  std::string output;
};

/// Runs a program to its end, a minute at most.
RunResult RunToEnd(std::vector<std::string> arguments);

}  // namespace chequer::test
