#pragma once

#include <string>

#include "capture/source_factory.h"
#include "core/toml_reader.h"
#include "support/error_of.h"

namespace chequer::test {

/// What lines of [capture] mean, in a file swarm.toml whose second line is the first of them.
inline CaptureOptions ReadCapture(const std::string& lines) {
  TomlFile file = TomlFile::Parse("[capture]\n" + lines, "swarm.toml");
  CaptureOptions options = ReadCaptureOptions(file.root().Table("capture"), "/data");
  file.CheckAllKeysRead();
  return options;
}

/// What is wrong with them; "no error" where nothing is.
inline std::string ReadCaptureError(const std::string& lines) {
  return ErrorOf([&] { ReadCapture(lines); });
}

}  // namespace chequer::test
