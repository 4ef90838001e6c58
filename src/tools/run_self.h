#pragma once

#include <string>
#include <vector>

namespace chequer {

/// Runs this program again with other arguments, as its user would; it has the terminal meanwhile, and Ctrl-C reaches
/// it alone. Its exit status, or 128 + the signal that ended it. Throws std::system_error where it cannot be started.
int RunSelf(const std::vector<std::string>& arguments);
/// The same with another program, looked for in PATH.
int RunProgram(const std::string& program, const std::vector<std::string>& arguments);

/// A command as a shell takes it: words with anything but letters, digits and -_./:=,+@ are quoted.
std::string ShellText(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace chequer
