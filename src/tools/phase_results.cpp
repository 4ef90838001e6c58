#include "tools/phase_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "capture/recording.h"
#include "chequer/camera_file.h"
#include "core/file.h"
#include "publish/lcm_log.h"
#include "tools/convert_log.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

/// The frames of a recording with their truth.
class TrueStream {
 public:
  explicit TrueStream(const fs::path& folder) : recording_(OpenRecording(folder)) {
    const RecordingInfo& info = recording_.info;
    if (info.truth.empty() || info.calibration.empty())
      throw std::runtime_error("recording " + folder.string() +
                               " has no truth; `chequer render --scenario` makes ones that have");
    camera_ = LoadCamera(folder / info.calibration);
    for (FrameTruth& frame : ReadTruth(folder / info.truth)) by_file_[frame.file] = std::move(frame);
    for (std::size_t i = 0; i < recording_.frames.size(); ++i) {
      const RecordedFrame& frame = recording_.frames[i];
      const auto truth = by_file_.find(frame.file);
      if (truth == by_file_.end())
        throw std::runtime_error("the truth of recording " + folder.string() + " has no line for " + frame.file);
      if (truth->second.phase.empty())
        throw std::runtime_error("the truth of recording " + folder.string() +
                                 " names no phases; `chequer render --scenario` makes ones that have");
      by_sequence_[frame.sequence] = i;
    }
  }

  std::size_t size() const { return recording_.frames.size(); }
  const CameraModel& camera() const { return camera_; }
  const FrameTruth& Truth(std::size_t index) const { return by_file_.at(recording_.frames[index].file); }
  /// Of one round, in which the next one's first frame is as far from the last as frames are on average.
  double RoundS() const {
    const double span = SinceFirst(size() - 1);
    return size() > 1 ? span * static_cast<double>(size()) / static_cast<double>(size() - 1) : 1 / recording_.info.fps;
  }
  double SinceFirst(std::size_t index) const {
    const auto span = recording_.frames[index].captured_monotonic - recording_.frames.front().captured_monotonic;
    return std::chrono::duration<double>(span).count();
  }

  /// Position of a file's frame; nothing where it is not in the recording.
  std::optional<std::size_t> OfFile(const std::string& name) const {
    const auto frame = std::find_if(recording_.frames.begin(), recording_.frames.end(),
                                    [&](const RecordedFrame& known) { return known.file == name; });
    if (frame == recording_.frames.end()) return std::nullopt;
    return static_cast<std::size_t>(frame - recording_.frames.begin());
  }
  /// Position of a sequence number, counted over all rounds.
  std::optional<std::size_t> OfSequence(std::uint64_t sequence) const {
    const std::uint64_t first = by_sequence_.begin()->first;
    if (sequence < first) return std::nullopt;
    const std::uint64_t numbers = by_sequence_.rbegin()->first - first + 1;
    const auto frame = by_sequence_.find(first + (sequence - first) % numbers);
    if (frame == by_sequence_.end()) return std::nullopt;
    return static_cast<std::size_t>((sequence - first) / numbers) * size() + frame->second;
  }

 private:
  Recording recording_;
  CameraModel camera_;
  std::map<std::string, FrameTruth> by_file_;
  std::map<std::uint64_t, std::size_t> by_sequence_;
};

/// What came of frames, by their position over all rounds.
using Answers = std::map<std::size_t, FoundFrame>;

void Keep(Answers& answers, std::optional<std::size_t> position, FoundFrame frame, const std::string& which) {
  if (!position) throw std::runtime_error(which + " is no frame of the recording with the truth");
  if (!answers.emplace(*position, std::move(frame)).second) throw std::runtime_error(which + " is there twice");
}

/// Throws where poses are not given as the truth is.
void CheckFrame(const std::string& frame, const std::string& which) {
  if (frame != "camera")
    throw std::runtime_error(which + " has its poses in the frame '" + frame + "'; the truth is in the camera's");
}

RigidTransform PoseFromJson(const nlohmann::json& found) {
  const auto t = found.at("position").get<std::array<double, 3>>();
  const auto q = found.at("orientation").get<std::array<double, 4>>();
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) throw std::runtime_error("\"orientation\" is not a unit quaternion");
  return {rotation.normalized(), {t[0], t[1], t[2]}};
}

Matrix6d CovarianceFromJson(const nlohmann::json& json) {
  const auto numbers = json.get<std::array<double, 21>>();
  Matrix6d covariance;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) covariance(row, col) = covariance(col, row) = numbers[next++];
  return covariance;
}

/// The mean of the corners that were seen: near enough to say which board it is.
Eigen::Vector2d MeanCorner(const nlohmann::json& corners) {
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (const nlohmann::json& corner : corners) {
    if (corner.is_null()) continue;
    const auto at = corner.get<std::array<double, 2>>();
    sum += Eigen::Vector2d(at[0], at[1]);
    ++count;
  }
  if (count == 0) throw std::runtime_error("a marker has neither a pose nor corners");
  return sum / count;
}

FoundMarker MarkerFromJson(const nlohmann::json& found, const CameraModel& camera) {
  FoundMarker marker;
  if (!found.at("id").is_null()) marker.id = found["id"].get<std::uint64_t>();
  marker.variant = found.value("variant", "");
  if (found.contains("warnings"))
    for (const nlohmann::json& warning : found["warnings"]) marker.carried |= warning == "id_carried";
  if (!found.contains("position")) {
    marker.center_px = MeanCorner(found.at("corners"));
    return marker;
  }
  marker.camera_from_marker = PoseFromJson(found);
  marker.center_px = camera.Project(marker.camera_from_marker->translation);
  if (found.contains("covariance")) marker.covariance = CovarianceFromJson(found["covariance"]);
  return marker;
}

/// What a line says: of `chequer detect --json`, or of poses that `chequer listen` or `chequer convert` printed.
FoundFrame FrameFromJson(const nlohmann::json& json, const CameraModel& camera) {
  FoundFrame frame;
  for (const nlohmann::json& marker : json.at("markers")) frame.markers.push_back(MarkerFromJson(marker, camera));
  if (json.contains("detect_ms")) frame.detect_ms = json["detect_ms"].get<double>();
  return frame;
}

Answers ReadJson(const fs::path& path, const TrueStream& stream, const std::string& channel) {
  std::istringstream file(ReadFile(path, kMaxTextBytes));
  Answers answers;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      const nlohmann::json json = nlohmann::json::parse(line);
      if (!json.is_object()) throw std::runtime_error("is not an object");
      if (json.value("type", "poses") != "poses" || (!channel.empty() && json.value("channel", "") != channel))
        continue;
      CheckFrame(json.value("frame", "camera"), "the line");
      FoundFrame frame = FrameFromJson(json, stream.camera());
      const std::string name = fs::path(json.value("file", "")).filename();
      if (!name.empty())
        Keep(answers, stream.OfFile(name), std::move(frame), name);
      else
        Keep(answers, stream.OfSequence(json.at("sequence").get<std::uint64_t>()), std::move(frame), "its frame");
    } catch (const std::exception& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}; a line must be what `chequer detect --json` prints",
                                           path.string(), number, error.what()));
    }
  }
  if (file.bad()) throw std::runtime_error(path.string() + " cannot be read to its end");
  return answers;
}

FoundFrame FrameOf(const PosesMessage& message, const CameraModel& camera) {
  FoundFrame frame;
  const auto latency = message.published_monotonic - message.captured_monotonic;
  frame.latency_ms = std::chrono::duration<double, std::milli>(latency).count();
  for (const MarkerPose& pose : message.markers) {
    if (!pose.has_pose)
      throw std::runtime_error(
          "a marker of the log has no pose; give chequerd the stream's camera.toml as calibration");
    frame.markers.push_back({.id = pose.id,
                             .variant = std::string(VariantName(pose.variant)),
                             .center_px = camera.Project(pose.camera_from_marker.translation),
                             .camera_from_marker = pose.camera_from_marker,
                             .covariance = pose.covariance,
                             .carried = pose.Has(Warning::kIdCarried)});
  }
  return frame;
}

Answers ReadLog(const fs::path& path, const TrueStream& stream, const std::string& channel) {
  LcmLogReader reader(path);
  Answers answers;
  std::set<std::string> channels;
  while (const auto record = reader.Next()) {
    const auto* poses = std::get_if<PosesMessage>(&record->message);
    if (!poses || (!channel.empty() && record->channel != channel)) continue;
    if (channels.insert(record->channel).second && channels.size() > 1)
      throw std::runtime_error(fmt::format("{} holds the poses of several cameras; choose one with --channel: {}",
                                           path.string(), fmt::join(channels, ", ")));
    const std::string which = fmt::format("{}: frame {}", path.string(), poses->sequence);
    CheckFrame(poses->frame, which);
    Keep(answers, stream.OfSequence(poses->sequence), FrameOf(*poses, stream.camera()), which);
  }
  if (reader.damaged())
    throw std::runtime_error(fmt::format("{} is cut off or damaged after {} frames", path.string(), answers.size()));
  return answers;
}

}  // namespace

PhaseRun ReadPhaseRun(const fs::path& results, const fs::path& recording, const std::string& channel) {
  const TrueStream stream(recording);
  const Answers answers = IsLcmLog(results) ? ReadLog(results, stream, channel) : ReadJson(results, stream, channel);
  if (answers.empty()) throw std::runtime_error(results.string() + " holds no frames");
  PhaseRun run{results.stem().string(), {}};
  // The last round is as long as answers say: nobody knows when its rest was to come.
  const std::size_t end = std::max(stream.size(), answers.rbegin()->first + 1);
  for (std::size_t position = 0; position < end; ++position) {
    const std::size_t index = position % stream.size();
    const FrameTruth& truth = stream.Truth(index);
    ScoredFrame frame{.phase = truth.phase, .time_s = 0, .score = {}, .detect_ms = {}, .latency_ms = {}};
    frame.time_s = static_cast<double>(position / stream.size()) * stream.RoundS() + stream.SinceFirst(index);
    if (const auto answer = answers.find(position); answer != answers.end()) {
      frame.score = ScoreFrame(answer->second, truth);
      frame.detect_ms = answer->second.detect_ms;
      frame.latency_ms = answer->second.latency_ms;
    }
    run.frames.push_back(std::move(frame));
  }
  return run;
}

}  // namespace chequer
