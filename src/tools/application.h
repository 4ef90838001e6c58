#pragma once

namespace CLI {
class App;
}

namespace chequer {

/// Gives `chequer` its description, options and commands: what the program parses, and what its manual page and the
/// completion of the shell are made from.
void DescribeTool(CLI::App& app);

}  // namespace chequer
