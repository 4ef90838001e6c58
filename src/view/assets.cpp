#include "view/assets.h"

#include <array>
#include <stdexcept>
#include <utility>

#include "core/file.h"

namespace chequer {
namespace {

constexpr std::size_t kMostBytes = 4u << 20;
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kTypes{
    {{".html", "text/html; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".svg", "image/svg+xml"}}};

std::string TypeOf(const std::filesystem::path& file) {
  for (const auto& [extension, type] : kTypes)
    if (file.extension() == extension) return std::string(type);
  return {};
}

}  // namespace

Assets Assets::Load(const std::filesystem::path& page, const std::filesystem::path& chart) {
  Assets assets;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(page, missing))
    if (const std::string type = TypeOf(entry.path()); !type.empty())
      assets.files_["/" + entry.path().filename().string()] = {type, ReadFile(entry.path(), kMostBytes)};
  if (assets.files_.count("/index.html") == 0)
    throw std::runtime_error(page.string() + ": the page's files are not there; is chequer installed whole?");
  assets.files_["/"] = assets.files_["/index.html"];
  if (!std::filesystem::is_regular_file(chart, missing))
    throw std::runtime_error(chart.string() +
                             ": the library of charts is not there; Debian's libjs-chart.js brings it");
  assets.files_["/chart.js"] = {TypeOf(chart), ReadFile(chart, kMostBytes)};
  return assets;
}

const Assets::File* Assets::Find(std::string_view path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

std::filesystem::path PageFolder(const std::filesystem::path& program) {
  const auto installed = program.parent_path().parent_path() / "share" / "chequer" / "view";
  // Beside the programs of a build tree lies a link to the sources.
  const auto built = program.parent_path().parent_path() / "view_page";
  for (const auto& folder : {installed, built})
    if (std::filesystem::is_regular_file(folder / "index.html")) return folder;
  throw std::runtime_error("the page's files are neither in " + installed.string() + " nor in " + built.string());
}

}  // namespace chequer
