#pragma once

#include <stdexcept>
#include <string>

namespace chequer::test {

/// What the error says that an action throws; "no error" if it throws none.
template <typename Action>
std::string ErrorOf(const Action& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace chequer::test
