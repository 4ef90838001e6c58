#include "tools/evaluation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace chequer {
namespace {

using Json = nlohmann::ordered_json;

double LengthOf(const TrackFit& track) {
  const auto [first, last] = std::minmax_element(track.along_m.begin(), track.along_m.end());
  return *last - *first;
}

std::vector<double> Millimetres(std::vector<double> metres) {
  for (double& value : metres) value *= 1e3;
  return metres;
}

std::string Row(const char* what, const ErrorMeasures& m) {
  return fmt::format("  {:22}{:>9.4f}{:>9.4f}{:>9.4f}{:>12.4f}{:>10.4f}\n", what, m.rmse, m.mae, m.largest,
                     m.printed_rmse, m.printed_mae);
}

Json MeasuresJson(const ErrorMeasures& m, const std::vector<double>& errors) {
  return {{"rmse", m.rmse},
          {"mae", m.mae},
          {"largest", m.largest},
          {"printed_rmse", m.printed_rmse},
          {"printed_mae", m.printed_mae},
          {"errors", errors}};
}

}  // namespace

Evaluation Evaluate(const Run& run, std::optional<std::uint64_t> id) {
  if (!id) id = MostSeen(run.frames);
  if (!id)
    throw std::runtime_error(
        fmt::format("{}: no id was read in any of its {} frames; `chequer explain` on an "
                    "image tells why",
                    run.name, run.frames.size()));
  Evaluation evaluation;
  evaluation.name = run.name;
  evaluation.others = SeenBeside(run.frames, *id);
  evaluation.recognition = CountRecognised(run.frames, *id, evaluation.others);
  const std::vector<RigidTransform> poses = PosesOf(run.frames, *id);
  evaluation.poses = static_cast<int>(poses.size());
  if (poses.size() < 3) return evaluation;
  const TrackFit track = FitTrack(poses);
  const TrackShape shape = ShapeOf(poses, track);
  if (!shape.is_straight) {
    evaluation.objection = fmt::format(
        "this is no straight track: over {:.3f} m it leaves the line that fits best by up to {:.0f} mm, in one sweep. "
        "Errors are measured against a line: evaluate a run of one marker that is moved along a straight track",
        LengthOf(track), 1e3 * *std::max_element(track.distance_m.begin(), track.distance_m.end()));
    return evaluation;
  }
  if (shape.is_turning)
    evaluation.objection =
        "the marker turns on its way: the angular errors are its turn. Move it along the track without turning it";
  evaluation.track = track;
  evaluation.linear_mm = MeasureErrors(Millimetres(evaluation.track->distance_m));
  evaluation.angular_deg = MeasureErrors(evaluation.track->angle_deg);
  return evaluation;
}

std::string Describe(const Evaluation& evaluation) {
  const Recognition& seen = evaluation.recognition;
  std::string text = fmt::format(
      "{}: id {} read in {} of {} frames, recognition rate {:.2f} %; {} left undecided, {} "
      "wrong id{}\n",
      evaluation.name, seen.id, seen.recognised, seen.frames, 100 * seen.Rate(), seen.undecided, seen.wrong,
      seen.wrong == 1 ? "" : "s");
  if (!evaluation.others.empty())
    text += fmt::format("  other markers in view, not counted as wrong: {}; --id chooses which one is measured\n",
                        fmt::join(evaluation.others, ", "));
  if (!evaluation.objection.empty()) text += "  " + evaluation.objection + "\n";
  if (!evaluation.track && evaluation.poses >= 3) return text;
  if (!evaluation.track)
    return text + fmt::format("  no track: {} pose{}, at least 3 are needed{}\n", evaluation.poses,
                              evaluation.poses == 1 ? "" : "s",
                              evaluation.poses == 0 ? "; `chequer detect` gives them with --calibration" : "");
  const TrackFit& track = *evaluation.track;
  text += fmt::format("  best line: {:.4f} m long through ({:.5f}, {:.5f}, {:.5f}) m along ({:.5f}, {:.5f}, {:.5f})\n",
                      LengthOf(track), track.center.x(), track.center.y(), track.center.z(), track.direction.x(),
                      track.direction.y(), track.direction.z());
  text += fmt::format("  best constant orientation: w {:.6f}, x {:.6f}, y {:.6f}, z {:.6f}\n", track.orientation.w(),
                      track.orientation.x(), track.orientation.y(), track.orientation.z());
  text += fmt::format("  {:22}{:>9}{:>9}{:>9}{:>12}{:>10}\n", "", "RMSE", "MAE", "largest", "sqrt(SSE)/n", "SAE/n");
  text += Row("linear error, mm", evaluation.linear_mm);
  text += Row("angular error, deg", evaluation.angular_deg);
  return text;
}

std::string JsonLine(const Evaluation& evaluation) {
  const Recognition& seen = evaluation.recognition;
  Json json{{"run", evaluation.name},
            {"id", seen.id},
            {"frames", seen.frames},
            {"recognised", seen.recognised},
            {"recognition_rate", seen.Rate()},
            {"undecided", seen.undecided},
            {"wrong", seen.wrong},
            {"poses", evaluation.poses},
            {"others", evaluation.others}};
  if (!evaluation.objection.empty()) json["objection"] = evaluation.objection;
  if (evaluation.track) {
    const TrackFit& track = *evaluation.track;
    const Eigen::Quaterniond& q = track.orientation;
    json["track"] = {{"length_m", LengthOf(track)},
                     {"point", {track.center.x(), track.center.y(), track.center.z()}},
                     {"direction", {track.direction.x(), track.direction.y(), track.direction.z()}},
                     {"orientation", {q.w(), q.x(), q.y(), q.z()}}};
    json["linear_mm"] = MeasuresJson(evaluation.linear_mm, Millimetres(track.distance_m));
    json["angular_deg"] = MeasuresJson(evaluation.angular_deg, track.angle_deg);
    json["along_m"] = track.along_m;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace chequer
