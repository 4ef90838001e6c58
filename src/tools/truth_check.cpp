#include "tools/truth_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "capture/recording.h"

namespace chequer {
namespace {

double Ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Streams have boards too that hands occlude or the image cuts off. Whether these are found or missed, both is right.
bool IsWhole(const TrueMarker& marker) { return marker.visible == 1; }

}  // namespace

TruthCheck::TruthCheck(const std::filesystem::path& folder, TruthTolerance tolerance) : tolerance_(tolerance) {
  const Recording recording = OpenRecording(folder);
  if (recording.info.truth.empty())
    throw std::runtime_error("recording " + folder.string() + " has no truth; `chequer render` makes ones that have");
  std::map<std::string, std::vector<TrueMarker>> by_file;
  for (FrameTruth& frame : ReadTruth(folder / recording.info.truth)) by_file[frame.file] = std::move(frame.markers);
  for (const RecordedFrame& frame : recording.frames) {
    const auto truth = by_file.find(frame.file);
    if (truth == by_file.end())
      throw std::runtime_error("the truth of recording " + folder.string() + " does not tell of " + frame.file);
    unseen_frames_[frame.sequence] = std::move(truth->second);
  }
  frames_in_recording_ = recording.frames.size();
}

void TruthCheck::Add(const PosesMessage& message) {
  const auto frame = unseen_frames_.find(message.sequence);
  if (frame == unseen_frames_.end()) {
    ++strange_frames_;
    return;
  }
  std::vector<TrueMarker> truth = std::move(frame->second);
  unseen_frames_.erase(frame);
  ++frames_;
  for (const TrueMarker& marker : truth) markers_in_frames_ += IsWhole(marker);
  for (const MarkerPose& found : message.markers) {
    if (!found.id) continue;  // undecided is no claim; it shows as not found
    const auto match = std::find_if(truth.begin(), truth.end(), [&](const TrueMarker& marker) {
      return marker.id == *found.id && marker.variant == VariantName(found.variant) && marker.size == found.size;
    });
    if (match == truth.end()) {
      ++wrong_ids_;
      continue;
    }
    Compare(found, *match);
    truth.erase(match);
  }
}

void TruthCheck::Compare(const MarkerPose& found, const TrueMarker& truth) {
  found_ += IsWhole(truth);
  if (!found.has_pose) {
    ++wrong_poses_;
    return;
  }
  const double distance_m = truth.camera_from_marker.translation.norm();
  const double error_m = (found.camera_from_marker.translation - truth.camera_from_marker.translation).norm();
  const double angle_deg =
      found.camera_from_marker.rotation.angularDistance(truth.camera_from_marker.rotation) * 180 / std::numbers::pi;
  if (!(error_m <= tolerance_.position * distance_m && angle_deg <= tolerance_.angle_deg)) ++wrong_poses_;
  ++compared_;
  sum_squared_error_m_ += error_m * error_m;
  worst_error_m_ = std::max(worst_error_m_, error_m);
  worst_relative_error_ = std::max(worst_relative_error_, error_m / distance_m);
  worst_angle_deg_ = std::max(worst_angle_deg_, angle_deg);
}

std::vector<std::string> TruthCheck::Failures() const {
  std::vector<std::string> failures;
  const auto check = [&](bool right, const std::string& wrong) {
    if (!right) failures.push_back(wrong);
  };
  check(Ratio(frames_, frames_in_recording_) >= tolerance_.least_frames, "too few frames came");
  check(strange_frames_ == 0, fmt::format("{} frames are not the recording's", strange_frames_));
  check(Ratio(found_, markers_in_frames_) >= tolerance_.least_markers, "too few markers were found");
  check(wrong_ids_ == 0, fmt::format("{} ids are wrong", wrong_ids_));
  check(wrong_poses_ == 0, fmt::format("{} poses are off by more than {:.1f} % of the distance or {:.0f} deg",
                                       wrong_poses_, 100 * tolerance_.position, tolerance_.angle_deg));
  return failures;
}

bool TruthCheck::Passed() const { return Failures().empty(); }

std::string TruthCheck::Summary() const {
  const double rms_mm = compared_ == 0 ? 0 : 1000 * std::sqrt(sum_squared_error_m_ / static_cast<double>(compared_));
  std::string text = fmt::format(
      "{} of {} frames, {} of {} markers found, {} wrong ids; position error {:.2f} mm rms, {:.2f} mm worst ({:.2f} % "
      "of the distance); worst angle {:.2f} deg: ",
      frames_, frames_in_recording_, found_, markers_in_frames_, wrong_ids_, rms_mm, 1000 * worst_error_m_,
      100 * worst_relative_error_, worst_angle_deg_);
  const std::vector<std::string> failures = Failures();
  if (failures.empty()) return text + "all as the truth says";
  text += "NOT as the truth says";
  for (const std::string& failure : failures) text.append("; ").append(failure);
  return text;
}

}  // namespace chequer
