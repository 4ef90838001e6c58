#pragma once

namespace chequer {

/// Prints the broken condition with its place on standard error and aborts.
[[noreturn]] void FailCheck(const char* condition, const char* file, int line, const char* message);

}  // namespace chequer

/// A condition that only a bug can break; checked in every build.
#define CHEQUER_CHECK(condition, message)                                   \
  do {                                                                      \
    if (!(condition)) [[unlikely]]                                          \
      ::chequer::FailCheck(#condition, __FILE__, __LINE__, message);        \
  } while (false)
