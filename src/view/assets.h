#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace chequer {

/// The files of the page, in memory: what is asked for is one of these names or nothing, whatever it looks like.
class Assets {
 public:
  struct File {
    std::string type;  ///< of its content, as HTTP names it
    std::string bytes;
  };

  /// Reads the page's own files, and the library of charts from where Debian installs it. Throws std::runtime_error
  /// naming the folder or file that is missing.
  static Assets Load(const std::filesystem::path& page, const std::filesystem::path& chart);

  /// The file of a path ("/", "/main.js"); null where there is none.
  const File* Find(std::string_view path) const;

 private:
  std::map<std::string, File, std::less<>> files_;
};

/// Where the page's files are: share/chequer/view beside the program's own bin, where it was installed, else what the
/// build left. Throws std::runtime_error naming both where neither is there.
std::filesystem::path PageFolder(const std::filesystem::path& program);

}  // namespace chequer
