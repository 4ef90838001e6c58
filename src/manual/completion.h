#pragma once

#include <string>

namespace CLI {
class App;
}

namespace chequer {

/// A function of bash, and its registration, that completes the command line of a program: its commands, the options of
/// each, and files where one is wanted. Needs nothing but bash.
std::string BashCompletion(const CLI::App& app);

}  // namespace chequer
