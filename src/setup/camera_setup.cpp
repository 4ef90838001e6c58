#include "setup/camera_setup.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/suggestion.h"
#include "core/toml_reader.h"
#include "setup/marker_table.h"
#include "setup/print_table.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFamilies = 64;
constexpr std::array<std::pair<std::string_view, ColorSpace>, 2> kColorSpaces{
    {{"lab", ColorSpace::kLab}, {"hsv", ColorSpace::kHsv}}};

std::optional<fs::path> ReadPath(TomlTable table, std::string_view key, const fs::path& base) {
  std::string path;
  if (!table.Read(key, path)) return std::nullopt;
  return base / path;
}

/// The names that FindCameraSetup would take, for messages.
std::vector<std::string> NamesIn(std::span<const fs::path> folders) {
  std::vector<std::string> names;
  for (const fs::path& folder : folders) {
    std::error_code unreadable;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, unreadable))
      if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

CameraSetup LoadCameraSetup(const fs::path& path) {
  TomlFile file = TomlFile::Load(path);
  TomlTable root = file.root();
  const fs::path base = path.parent_path();
  CameraSetup setup;
  setup.file = path;
  root.Table("camera").Read("name", setup.camera_name);
  setup.calibration = ReadPath(root.Table("camera"), "calibration", base);
  setup.world = ReadPath(root.Table("world"), "file", base);
  setup.robots = ReadPath(root.Table("robots"), "file", base);
  if (root.Has("capture")) setup.capture = ReadCaptureOptions(root.Table("capture"), base);
  if (std::string url; root.Table("publish").Read("url", url)) setup.publish_url = url;
  if (std::string prefix; root.Table("publish").Read("prefix", prefix)) setup.publish_prefix = prefix;
  if (bool allow = false; root.Table("view").Read("allow", allow)) setup.allow_view = allow;
  root.Table("detect").Read("color_space", setup.color_space, kColorSpaces);
  setup.print_tolerance = ReadPrintTolerance(root.Table("print"));
  for (TomlTable& table : root.Tables("marker", kMaxFamilies))
    setup.families.push_back(ReadMarkerFamily(table, base, false));
  return setup;
}

fs::path FindCameraSetup(const std::string& typed, std::span<const fs::path> folders) {
  if (typed.find('/') != std::string::npos || typed.ends_with(".toml")) return typed;
  std::error_code unknown;
  if (fs::is_regular_file(typed, unknown)) return typed;
  std::string places;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / (typed + ".toml");
    if (fs::is_regular_file(file, unknown)) return file;
    places += (places.empty() ? "" : " nor ") + file.string();
  }
  throw std::runtime_error("--config " + typed + ": there is neither a file of that name nor " + places +
                           DidYouMean(typed, NamesIn(folders)));
}

fs::path FindCameraSetup(const std::string& typed) {
  const std::array<fs::path, 2> folders{"", kServiceFolder};
  return FindCameraSetup(typed, folders);
}

}  // namespace chequer
