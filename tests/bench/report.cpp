#include "bench/report.h"

#include <fmt/format.h>

#include <fstream>
#include <opencv2/core/version.hpp>

namespace chequer::bench {
namespace {

using nlohmann::json;

std::string Processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string FormatScore(const Score& score, bool with_track) {
  std::string text =
      fmt::format("{:8d} {:7.4f} {:6d} {:6d}", score.markers, score.Recall(), score.wrong, score.undecided);
  if (score.pose) {
    const PoseErrors& pose = *score.pose;
    text += fmt::format(" {:9.3f} {:9.3f} {:9.3f} {:8.3f} {:8.3f}", pose.position_rms_mm, pose.lateral_rms_mm,
                        pose.depth_rms_mm, pose.angle_rms_deg, pose.angle_median_deg);
  }
  if (with_track && score.track) {
    text += fmt::format(" {:8.3f} {:8.3f} {:8.3f} {:8.3f}", score.track->linear_rms_mm, score.track->linear_mean_mm,
                        score.track->angular_rms_deg, score.track->angular_mean_deg);
  }
  return text + "\n";
}

/// Of our own detections; the bound is that of our boards.
bool HasBound(const Result& result) { return result.contestant.starts_with("chequer"); }

/// How many times the least possible errors are.
std::string FormatDistance(const Score& score, const ErrorBound& bound) {
  if (!score.pose || !score.track) return "";
  return fmt::format(" {:7.2f} {:7.2f} {:7.2f} {:7.2f}", score.pose->position_rms_mm / bound.position_rms_mm,
                     score.pose->angle_rms_deg / bound.angle_rms_deg,
                     score.track->linear_rms_mm / bound.track.linear_rms_mm,
                     score.track->angular_rms_deg / bound.track.angular_rms_deg);
}

std::string FormatBound(const std::string& name, const ErrorBound& bound) {
  return fmt::format("  {:22} {:6} {:9} {:6} {:40.4f} {:38.4f} {:8.4f} {:17.4f}\n", name, "", "", "",
                     bound.position_rms_mm, bound.angle_rms_deg, bound.track.linear_rms_mm,
                     bound.track.angular_rms_deg);
}

std::string FormatBounds(const Suite& suite) {
  std::string text;
  for (const auto& [condition, bounds] : suite.bounds)
    text += FormatBound("bound of " + condition, bounds.alone) + FormatBound("  levels known", bounds.levels_known);
  return text;
}

json ToJson(const ErrorBound& bound) {
  return {{"position_rms_mm", bound.position_rms_mm},
          {"angle_rms_deg", bound.angle_rms_deg},
          {"linear_rms_mm", bound.track.linear_rms_mm},
          {"angular_rms_deg", bound.track.angular_rms_deg}};
}

json ToJson(const Score& score, bool with_track) {
  json result{
      {"markers", score.markers}, {"recall", score.Recall()}, {"wrong", score.wrong}, {"undecided", score.undecided}};
  if (score.pose) {
    const PoseErrors& pose = *score.pose;
    result["pose"] = {{"position_rms_mm", pose.position_rms_mm}, {"position_median_mm", pose.position_median_mm},
                      {"lateral_rms_mm", pose.lateral_rms_mm},   {"depth_rms_mm", pose.depth_rms_mm},
                      {"angle_rms_deg", pose.angle_rms_deg},     {"angle_median_deg", pose.angle_median_deg}};
  }
  if (with_track && score.track) {
    result["track"] = {{"linear_rms_mm", score.track->linear_rms_mm},
                       {"linear_mean_mm", score.track->linear_mean_mm},
                       {"angular_rms_deg", score.track->angular_rms_deg},
                       {"angular_mean_deg", score.track->angular_mean_deg}};
  }
  return result;
}

}  // namespace

std::string FormatTable(const Suite& suite, const std::vector<Result>& results, bool by_condition) {
  std::string table =
      fmt::format("{}: {} x {}, side {} m\n", suite.name, suite.camera.width, suite.camera.height, suite.side_m);
  table += fmt::format("{:24} {:>6} {:>9} {:>6} {:>8} {:>7} {:>6} {:>6} {:>9} {:>9} {:>9} {:>8} {:>8}", "", "frames",
                       "ms", "times", "markers", "recall", "wrong", "undec.", "pos mm", "lat mm", "depth mm", "ang deg",
                       "ang med");
  if (suite.straight_tracks)
    table += fmt::format(" {:>8} {:>8} {:>8} {:>8}", "line rms", "mean mm", "turn rms", "mean deg");
  if (!suite.bounds.empty())
    table += fmt::format(" {:>7} {:>7} {:>7} {:>7}", "pos/bnd", "ang/bnd", "lin/bnd", "trn/bnd");
  table += "\n";
  if (by_condition) table += FormatBounds(suite);
  for (const Result& result : results) {
    table += fmt::format("{:24} {:6d} {:9.3f} {:6.2f} ", result.contestant, result.frames, result.ms,
                         result.ms / results.front().ms);
    table += FormatScore(result.total, false);
    if (!by_condition) continue;
    for (const auto& [condition, score] : result.conditions) {
      std::string line =
          fmt::format("  {:22} {:6} {:9} {:6} ", condition, "", "", "") + FormatScore(score, suite.straight_tracks);
      const auto bound = suite.bounds.find(condition);
      if (bound != suite.bounds.end() && HasBound(result))
        line.insert(line.size() - 1, FormatDistance(score, bound->second.alone));
      table += line;
    }
  }
  return table;
}

json ToJson(const Suite& suite, const std::vector<Result>& results) {
  json detectors = json::array();
  for (const Result& result : results) {
    json detector = ToJson(result.total, false);
    detector["name"] = result.contestant;
    detector["frames"] = result.frames;
    detector["ms"] = result.ms;
    detector["conditions"] = json::array();
    for (const auto& [condition, score] : result.conditions) {
      json entry = ToJson(score, suite.straight_tracks);
      entry["condition"] = condition;
      detector["conditions"].push_back(std::move(entry));
    }
    detectors.push_back(std::move(detector));
  }
  json bounds = json::object();
  for (const auto& [condition, of_condition] : suite.bounds) {
    bounds[condition] = ToJson(of_condition.alone);
    bounds[condition]["levels_known"] = ToJson(of_condition.levels_known);
  }
  return {{"suite", suite.name},
          {"side_m", suite.side_m},
          {"width", suite.camera.width},
          {"height", suite.camera.height},
          {"detectors", std::move(detectors)},
          {"bounds", std::move(bounds)}};
}

json DescribeMachine() {
  return {{"processor", Processor()}, {"opencv", CV_VERSION}, {"apriltag", CHEQUER_APRILTAG_VERSION}};
}

}  // namespace chequer::bench
