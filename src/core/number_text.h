#pragma once

#include <string>

namespace chequer {

/// The shortest text that reads back as the same number.
std::string ExactText(double number);

}  // namespace chequer
