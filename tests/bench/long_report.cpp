#include "bench/long_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace chequer::bench {
namespace {

constexpr std::array<std::pair<std::string_view, double>, 5> kReferenceRecall{
    {{"dark", 0.999}, {"fast", 0.999}, {"bright", 0.998}, {"knock", 0.79}, {"hands", 0.81}}};
/// Of a knock's work over a calm frame's.
constexpr double kMedianKnock = 10, kLargestKnock = 20;

double Share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Median units of the calm frames of each stream.
std::map<std::string, double> CalmWork(const std::vector<PhaseTally>& phases) {
  std::map<std::string, double> calm;
  for (const PhaseTally& phase : phases)
    if (phase.phase == "calm") calm[phase.stream] = phase.work.Quantile(0.5);
  return calm;
}

std::string Marked(double value, bool good, const char* form) {
  return fmt::format(fmt::runtime(form), value) + (good ? ' ' : '!');
}

std::string ReadingRow(const PhaseTally& phase) {
  const double recall = Share(phase.read, phase.expected);
  const auto least = LeastRecall(phase.stream, phase.phase);
  return fmt::format("{:22}{:>9}{:>10}{:>10}{:>9}{:>10.6f}{:>11}{:>7}{:>7}{:>8}{:>10}\n",
                     phase.stream + "/" + phase.phase, phase.frames, phase.expected,
                     Marked(recall, !least || recall >= *least, "{:.6f}"), least ? fmt::format("{:g}", *least) : "-",
                     Share(phase.whole_read, phase.whole), phase.undecided, phase.wrong, phase.twice, phase.ghosts,
                     phase.deferred);
}

std::string WorkRow(const PhaseTally& phase, double calm) {
  const bool knocked = phase.stream == "reference" && phase.phase == "knock";
  const double median = phase.work.Quantile(0.5), p99 = phase.work.Quantile(0.99);
  const auto over_calm = [&](double units, double most) {
    return calm > 0 ? Marked(units / calm, !knocked || units <= most * calm, "{:.2f}") : "-";
  };
  return fmt::format("{:22}{:>10.0f}{:>10.0f}{:>10.0f}{:>10}{:>10}{:>10.3f}{:>10.1f}{:>10.3f}{:>10.1f}\n",
                     phase.stream + "/" + phase.phase, median, p99, phase.work.largest(),
                     over_calm(median, kMedianKnock), over_calm(p99, kLargestKnock),
                     phase.position_over_covariance.mean(), phase.position_over_covariance.Quantile(0.999),
                     phase.rotation_over_covariance.mean(), phase.rotation_over_covariance.Quantile(0.999));
}

}  // namespace

std::optional<double> LeastRecall(std::string_view stream, std::string_view phase) {
  if (phase.starts_with("calm")) return 1;
  if (stream != "reference") return std::nullopt;
  const auto known = std::find_if(kReferenceRecall.begin(), kReferenceRecall.end(),
                                  [&](const auto& entry) { return entry.first == phase; });
  if (known == kReferenceRecall.end()) return std::nullopt;
  return known->second;
}

std::string DescribeRun(const std::vector<PhaseTally>& phases) {
  std::string text =
      fmt::format("{:22}{:>9}{:>10}{:>10}{:>9}{:>10}{:>11}{:>7}{:>7}{:>8}{:>10}\n", "phase", "frames", "boards",
                  "recall ", "must", "whole", "undecided", "wrong", "twice", "ghosts", "deferred");
  PhaseTally all;
  for (const PhaseTally& phase : phases) {
    text += ReadingRow(phase);
    all.frames += phase.frames;
    all.expected += phase.expected;
    all.read += phase.read;
    all.whole += phase.whole;
    all.whole_read += phase.whole_read;
    all.undecided += phase.undecided;
    all.wrong += phase.wrong;
    all.twice += phase.twice;
    all.ghosts += phase.ghosts;
    all.deferred += phase.deferred;
  }
  all.stream = "all";
  text += ReadingRow(all);
  text += fmt::format("\n{:22}{:^30}{:^20}{:^40}\n", "", "work, units a frame", "over calm", "error2/covariance");
  text += fmt::format("{:22}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}\n", "phase", "median", "99 %", "max",
                      "median ", "99 % ", "position", "99.9 %", "rotation", "99.9 %");
  const auto calm = CalmWork(phases);
  for (const PhaseTally& phase : phases) {
    const auto entry = calm.find(phase.stream);
    text += WorkRow(phase, entry == calm.end() ? 0 : entry->second);
  }
  return text;
}

std::string DescribeMemory(const MemoryWatch& watch) {
  std::string text = "frames, resident MB:";
  const std::size_t step = std::max<std::size_t>(1, watch.samples().size() / 10);
  for (std::size_t i = 0; i < watch.samples().size(); i += step)
    text += fmt::format("  {}: {:.1f}", watch.samples()[i].frames, watch.samples()[i].megabytes);
  return text + fmt::format("\nafter the first tenth it grew by {:.1f} MB\n", watch.Growth());
}

}  // namespace chequer::bench
