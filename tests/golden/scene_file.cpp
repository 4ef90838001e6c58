#include "golden/scene_file.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <stdexcept>

#include "chequer/camera_file.h"
#include "core/toml_reader.h"

namespace chequer::golden {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMaxFamilies = 16;

MarkerSize ParseSize(const std::string& text) {
  const std::optional<MarkerSize> size = ParseMarkerSize(text);
  if (!size) throw std::runtime_error("\"" + text + "\" is not a size such as 6x6");
  return *size;
}

Variant ParseVariantName(const std::string& text) {
  const std::optional<Variant> variant = ParseVariant(text);
  if (!variant) throw std::runtime_error("\"" + text + "\" is not a variant");
  return *variant;
}

MarkerFamily ReadFamily(TomlTable& table, const fs::path& folder) {
  std::string size = "6x6";
  std::string variant = "secded";
  std::string kernels;
  double side_m = 0;
  table.Require("size", size);
  table.Require("variant", variant);
  table.Require("side", side_m, NumberRange{0.001, 10});
  table.Read("table", kernels);
  const MarkerSize parsed = ParseSize(size);
  MarkerCode code =
      kernels.empty() ? MarkerCode(parsed, ParseVariantName(variant)) : MarkerCode::LoadTable(parsed, folder / kernels);
  return {std::move(code), side_m, {}};
}

/// Reads scene.toml; returns the number of frames it states.
int ReadSceneFile(const fs::path& folder, GoldenScene& scene) {
  TomlFile file = TomlFile::Load(folder / "scene.toml");
  TomlTable root = file.root();
  int frame_count = 0;
  std::string pixel_format = "BGR8";
  double gamma = 0;
  root.Require("description", scene.description);
  root.Require("frames", frame_count, IntegerRange{1, 1000});
  root.Read("pixel_format", pixel_format);
  if (root.Read("gamma", gamma, NumberRange{0.2, 5})) scene.tone_curve = ToneCurve::Gamma(gamma);
  constexpr std::array<std::pair<std::string_view, ColorSpace>, 2> kColorSpaces{
      {{"lab", ColorSpace::kLab}, {"hsv", ColorSpace::kHsv}}};
  root.Read("color_space", scene.options.color_space, kColorSpaces);
  const std::optional<PixelFormat> format = ParsePixelFormat(pixel_format);
  if (!format) root.Fail("pixel_format", "must be one of " + PixelFormatNames());
  scene.pixel_format = *format;

  scene.options.families.clear();
  for (TomlTable& table : root.Tables("marker", kMaxFamilies))
    scene.options.families.push_back(ReadFamily(table, folder));

  TomlTable expect = root.Table("expect");
  expect.Require("min_detections", scene.min_detections, IntegerRange{0, 1'000'000});
  const bool has_markers = scene.min_detections > 0;
  const NumberRange positive{1e-6, 1e6};
  // A scene without markers has nothing to be tolerant about.
  if (has_markers || expect.Has("corner_px")) {
    expect.Require("corner_px", scene.tolerances.corner_px, positive);
    expect.Require("position_mm", scene.tolerances.position_mm, positive);
    expect.Require("angle_deg", scene.tolerances.angle_deg, positive);
  }
  file.CheckAllKeysRead();
  return frame_count;
}

ExpectedMarker ParseMarker(const json& marker) {
  ExpectedMarker expected;
  const auto t = marker.at("position").get<std::array<double, 3>>();
  const auto q = marker.at("orientation").get<std::array<double, 4>>();
  const auto center = marker.at("center_px").get<std::array<double, 2>>();
  expected.id = marker.at("id").get<std::uint64_t>();
  expected.variant = ParseVariantName(marker.at("variant").get<std::string>());
  expected.size = ParseSize(marker.at("size").get<std::string>());
  expected.side_m = marker.at("side").get<double>();
  expected.camera_from_marker = {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), {t[0], t[1], t[2]}};
  expected.center_px = {center[0], center[1]};
  expected.cell_px = marker.at("cell_px").get<double>();
  return expected;
}

std::vector<ExpectedFrame> ReadTruth(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  std::vector<ExpectedFrame> frames;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    try {
      const json entry = json::parse(line);
      ExpectedFrame& frame = frames.emplace_back();
      frame.file = entry.at("file").get<std::string>();
      for (const json& marker : entry.at("markers")) frame.markers.push_back(ParseMarker(marker));
    } catch (const std::exception& error) {
      throw std::runtime_error(path.string() + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return frames;
}

/// The images of a folder, by name.
std::set<std::string> ImageFiles(const fs::path& folder) {
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".png" || extension == ".jpg") files.insert(entry.path().filename().string());
  }
  return files;
}

}  // namespace

std::vector<Eigen::Vector2d> ExpectedMarker::CornersPx(const CameraModel& camera) const {
  const double cell_m = side_m / std::max(size.rows, size.cols);
  std::vector<Eigen::Vector2d> corners;
  for (int row = 1; row < size.rows; ++row) {
    for (int col = 1; col < size.cols; ++col) {
      const Eigen::Vector3d in_marker((col - 0.5 * size.cols) * cell_m, (0.5 * size.rows - row) * cell_m, 0);
      corners.push_back(camera.Project(camera_from_marker * in_marker));
    }
  }
  return corners;
}

GoldenScene LoadScene(const fs::path& folder) {
  GoldenScene scene;
  scene.name = folder.filename().string();
  const int frame_count = ReadSceneFile(folder, scene);
  scene.options.camera = LoadCamera(folder / "camera.toml");
  scene.frames = ReadTruth(folder / "truth.jsonl");
  std::set<std::string> expected;
  for (const ExpectedFrame& frame : scene.frames) expected.insert(frame.file);
  const std::set<std::string> present = ImageFiles(folder);
  if (present.size() != static_cast<std::size_t>(frame_count) || present != expected ||
      scene.frames.size() != expected.size()) {
    throw std::runtime_error(folder.string() + ": scene.toml states " + std::to_string(frame_count) +
                             " frames, the folder holds " + std::to_string(present.size()) +
                             " images and truth.jsonl " + std::to_string(scene.frames.size()) +
                             " lines; they must be the same files");
  }
  return scene;
}

Image LoadFrame(const fs::path& path, const GoldenScene& scene) {
  const bool colour = scene.pixel_format == PixelFormat::kBgr8;
  const cv::Mat pixels = cv::imread(path.string(), colour ? cv::IMREAD_COLOR : cv::IMREAD_UNCHANGED);
  if (pixels.empty()) throw std::runtime_error(path.string() + ": not a readable image");
  if (!colour && pixels.type() != CV_8UC1) throw std::runtime_error(path.string() + ": must have one 8-bit channel");
  Image image(scene.pixel_format, pixels.cols, pixels.rows, scene.tone_curve);
  const auto row_bytes = static_cast<std::size_t>(pixels.cols) * pixels.elemSize();
  for (int y = 0; y < pixels.rows; ++y) {
    std::copy_n(pixels.ptr<std::uint8_t>(y), row_bytes, image.bytes().data() + static_cast<std::size_t>(y) * row_bytes);
  }
  return image;
}

}  // namespace chequer::golden
