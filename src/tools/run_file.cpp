#include "tools/run_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <variant>

#include "core/file.h"
#include "publish/lcm_log.h"
#include "tools/convert_log.h"

namespace chequer {
namespace {

/// Numbers of an array of exactly that many.
template <std::size_t count>
std::array<double, count> Numbers(const nlohmann::json& marker, const char* key) {
  const nlohmann::json& values = marker.at(key);
  if (!values.is_array() || values.size() != count)
    throw std::runtime_error(fmt::format("\"{}\" must be {} numbers", key, count));
  std::array<double, count> numbers{};
  for (std::size_t i = 0; i < count; ++i) {
    if (!values[i].is_number()) throw std::runtime_error(fmt::format("\"{}\" must be {} numbers", key, count));
    numbers[i] = values[i].get<double>();
  }
  return numbers;
}

SeenMarker ReadMarker(const nlohmann::json& found) {
  SeenMarker marker;
  const auto& id = found.at("id");
  if (!id.is_null() && !id.is_number_unsigned()) throw std::runtime_error("\"id\" must be a whole number or null");
  if (!id.is_null()) marker.id = id.get<std::uint64_t>();
  if (!found.contains("position")) return marker;
  const auto position = Numbers<3>(found, "position");
  const auto q = Numbers<4>(found, "orientation");
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) throw std::runtime_error("\"orientation\" is not a unit quaternion");
  marker.camera_from_marker = RigidTransform{rotation.normalized(), {position[0], position[1], position[2]}};
  return marker;
}

/// Far more than a frame with all markers that fit into it takes.
constexpr std::size_t kLongestLine = 16u << 20;

/// The next line without its end; false at the end of the file. Throws where it is no text that ends.
bool NextLine(std::istream& file, std::string& line) {
  line.clear();
  std::streambuf& bytes = *file.rdbuf();
  for (int c = bytes.sbumpc(); c != std::char_traits<char>::eof(); c = bytes.sbumpc()) {
    if (c == '\n') return true;
    if (line.size() == kLongestLine) throw std::runtime_error("is no text: the line has no end");
    line.push_back(static_cast<char>(c));
  }
  return !line.empty();
}

std::vector<SeenFrame> ReadJsonLines(const std::filesystem::path& path, const std::string& channel) {
  std::istringstream file(ReadFile(path, kMaxTextBytes));
  std::vector<SeenFrame> frames;
  std::set<std::string> channels;
  int number = 0;
  for (std::string line;;) {
    ++number;
    try {
      if (!NextLine(file, line)) break;
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      const nlohmann::json frame = nlohmann::json::parse(line);
      if (!frame.is_object()) throw std::runtime_error("is not an object");
      if (frame.value("type", "poses") != "poses") continue;
      const std::string from = frame.value("channel", "");
      if (!channel.empty() && from != channel) continue;
      channels.insert(from);
      SeenFrame seen;
      for (const nlohmann::json& marker : frame.at("markers")) seen.push_back(ReadMarker(marker));
      frames.push_back(std::move(seen));
    } catch (const std::exception& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}; a line must be what `chequer detect --json` prints",
                                           path.string(), number, error.what()));
    }
  }
  if (channels.size() > 1)
    throw std::runtime_error(fmt::format("{} holds the poses of several cameras; choose one with --channel: {}",
                                         path.string(), fmt::join(channels, ", ")));
  return frames;
}

std::vector<SeenFrame> ReadLog(const std::filesystem::path& path, const std::string& channel) {
  LcmLogReader reader(path);
  std::vector<SeenFrame> frames;
  std::set<std::string> channels;
  while (const auto record = reader.Next()) {
    const auto* poses = std::get_if<PosesMessage>(&record->message);
    if (!poses || (!channel.empty() && record->channel != channel)) continue;
    channels.insert(record->channel);
    SeenFrame& frame = frames.emplace_back();
    for (const MarkerPose& marker : poses->markers) {
      frame.push_back({marker.id, std::nullopt});
      if (marker.has_pose) frame.back().camera_from_marker = marker.camera_from_marker;
    }
  }
  if (reader.damaged())
    throw std::runtime_error(fmt::format("{} is cut off or damaged after {} frames", path.string(), frames.size()));
  if (channels.size() > 1)
    throw std::runtime_error(fmt::format("{} holds the poses of several cameras; choose one with --channel: {}",
                                         path.string(), fmt::join(channels, ", ")));
  return frames;
}

}  // namespace

Run ReadRun(const std::filesystem::path& path, const std::string& channel) {
  if (std::filesystem::is_directory(path))
    throw std::runtime_error(
        path.string() + " is a folder, not a run; of frames, `chequer detect --json FOLDER > run.jsonl` makes a run");
  Run run{path.stem().string(), IsLcmLog(path) ? ReadLog(path, channel) : ReadJsonLines(path, channel)};
  if (run.frames.empty())
    throw std::runtime_error(path.string() + " holds no frames" +
                             (channel.empty() ? std::string() : " of channel " + channel));
  return run;
}

}  // namespace chequer
