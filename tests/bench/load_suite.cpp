#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "bench/frames.h"

namespace chequer::bench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

Image ReadImage(const fs::path& path, PixelFormat format) {
  const bool colour = format == PixelFormat::kBgr8;
  const cv::Mat pixels = cv::imread(path.string(), colour ? cv::IMREAD_COLOR : cv::IMREAD_GRAYSCALE);
  if (pixels.empty()) throw std::runtime_error(path.string() + ": not a readable image");
  Image image(format, pixels.cols, pixels.rows);
  const auto row_bytes = static_cast<std::size_t>(pixels.cols) * pixels.elemSize();
  for (int y = 0; y < pixels.rows; ++y) {
    std::copy_n(pixels.ptr<std::uint8_t>(y), row_bytes, image.bytes().data() + static_cast<std::size_t>(y) * row_bytes);
  }
  return image;
}

CameraModel ReadCamera(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  const json camera = json::parse(file);
  CameraModel model{.width = camera.at("w").get<int>(),
                    .height = camera.at("h").get<int>(),
                    .fx = camera.at("fx").get<double>(),
                    .fy = camera.at("fy").get<double>(),
                    .cx = camera.at("cx").get<double>(),
                    .cy = camera.at("cy").get<double>(),
                    .kind = CameraModel::Kind::kBrownConrady};
  model.distortion = {camera.at("k1").get<double>(), camera.at("k2").get<double>(), camera.at("p1").get<double>(),
                      camera.at("p2").get<double>(), 0};
  return model;
}

TrueMarker ParseMarker(const json& marker) {
  const auto t = marker.at("t").get<std::array<double, 3>>();
  const auto q = marker.at("q").get<std::array<double, 4>>();
  const auto px = marker.at("px").get<std::array<double, 2>>();
  TrueMarker truth;
  truth.id = marker.at("id").get<std::uint64_t>();
  truth.camera_from_marker = {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), {t[0], t[1], t[2]}};
  truth.center_px = {px[0], px[1]};
  truth.cell_px = marker.at("cell_px").get<double>();
  return truth;
}

std::vector<BenchFrame> ReadFrames(const fs::path& folder) {
  const fs::path truth_path = folder / "truth.jsonl";
  std::ifstream lines(truth_path);
  if (!lines) throw std::runtime_error(truth_path.string() + ": cannot be read");
  std::vector<BenchFrame> frames;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    const json entry = json::parse(line);
    const auto file = entry.at("file").get<std::string>();
    BenchFrame frame;
    frame.condition = entry.at("tag").get<std::string>();
    frame.colour = ReadImage(folder / file, PixelFormat::kBgr8);
    const fs::path raw = folder / ("raw_" + file);
    if (fs::exists(raw)) frame.bayer = ReadImage(raw, PixelFormat::kBayerRg8);
    for (const json& marker : entry.at("markers")) frame.truth.push_back(ParseMarker(marker));
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

bool Suite::HasMarkers() const {
  for (const auto& [pattern, list] : frames) {
    for (const BenchFrame& frame : list) {
      if (!frame.truth.empty()) return true;
    }
  }
  return false;
}

double DefaultSide(std::string_view suite) {
  if (suite == "swarm50" || suite == "stream50" || suite == "swarm100") return 0.10;
  if (suite == "swarm200" || suite == "stream200") return 0.08;
  return 0.12;
}

Suite LoadSuite(const fs::path& folder, double side_m, const std::vector<Print>& prints) {
  Suite suite;
  suite.name = folder.filename().string();
  suite.side_m = side_m;
  suite.straight_tracks = suite.name == "paper";
  std::string folders;
  for (const Print& print : prints) {
    const fs::path pattern_folder = folder / print.pattern;
    folders += (folders.empty() ? "" : ", ") + print.pattern;
    if (!fs::exists(pattern_folder)) continue;
    try {
      suite.camera = ReadCamera(pattern_folder / "camera.json");
      suite.frames[print.pattern] = ReadFrames(pattern_folder);
    } catch (const json::exception& error) {
      throw std::runtime_error(pattern_folder.string() + ": camera.json or truth.jsonl: " + error.what());
    }
  }
  if (suite.frames.empty()) {
    throw std::runtime_error(folder.string() + ": holds none of the folders " + folders);
  }
  return suite;
}

}  // namespace chequer::bench
