#pragma once

#include <filesystem>
#include <string>

namespace chequer::test {

/// A new empty folder under the system's temporary one, removed with all that is in it at the end.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::filesystem::path operator/(const TemporaryDirectory& folder, const std::filesystem::path& name) {
  return folder.path() / name;
}

}  // namespace chequer::test
