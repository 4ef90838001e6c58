// Writes manual pages and completions at build time: chequer_manual FOLDER SAMPLE PROGRAM_NOTES. They are made from
// what the programs parse their command lines by, and from the sample configuration, so that they cannot say otherwise.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "core/file.h"
#include "daemon/command_line.h"
#include "manual/completion.h"
#include "manual/config_page.h"
#include "manual/program_page.h"
#include "tools/application.h"

namespace {

void WriteAll(const std::filesystem::path& folder, const std::filesystem::path& sample,
              const std::filesystem::path& notes) {
  constexpr std::size_t kMost = 1 << 20;
  const auto write = [&](const char* name, const std::string& text) {
    chequer::WriteFileAtomically(folder / name, text);
  };
  CLI::App tool;
  chequer::DescribeTool(tool);
  write("chequer.1", chequer::ManualPage(
                         tool, CHEQUER_VERSION,
                         {.section = 1,
                          .summary = "print and find colour-checkerboard markers, calibrate cameras, listen to poses",
                          .more = {},
                          .see_also = "chequerd(8), chequerd.toml(5), chequer-camera.toml(5), "
                                      "chequer-recording(5), chequer-scenario.toml(5), chequer-world.toml(5)"}));
  write("chequer", chequer::BashCompletion(tool));
  CLI::App daemon;
  chequer::DaemonCommandLine command_line;
  chequer::DescribeDaemon(daemon, command_line);
  write("chequerd.8", chequer::ManualPage(daemon, CHEQUER_VERSION,
                                          {.section = 8,
                                           .summary = "publish the poses of colour-checkerboard markers over LCM",
                                           .more = chequer::ReadFile(notes, kMost),
                                           .see_also = "chequer(1), chequerd.toml(5), systemctl(1), journalctl(1)"}));
  write("chequerd", chequer::BashCompletion(daemon));
  write("chequerd.toml.5", chequer::ConfigPage(chequer::ReadFile(sample, kMost), CHEQUER_VERSION));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: chequer_manual FOLDER SAMPLE_CONFIGURATION CHEQUERD_NOTES\n");
    return 2;
  }
  try {
    WriteAll(argv[1], argv[2], argv[3]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "chequer_manual: %s\n", error.what());
    return 1;
  }
}
