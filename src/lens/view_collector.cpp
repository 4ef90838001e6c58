#include "lens/view_collector.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace chequer {
namespace {

constexpr std::size_t kFewestOfTarget = 8;
/// Blurred: edges this many times as wide as in the sharpest quarter of the views taken, and wider than a good lens
/// has.
constexpr double kBlurRatio = 1.6, kSharpPx = 3;
/// Alike: the points moved by less than this share of the image's width, on average, and against each other by less
/// than that share of how far they are spread. A tilt that grows from 20 to 27 degrees, or a turn by 3, is new.
constexpr double kAlikeShare = 0.03, kAlikeShape = 0.05;
/// About 20 degrees.
constexpr double kTilted = 1.06;

}  // namespace

ViewVerdict ViewCollector::Offer(LensView view, Reload reload) {
  ++offered_;
  if (view.points.size() < kFewestOfTarget) return ViewVerdict::kNothingSeen;
  if (!options_.keep_all && IsBlurred(view)) return ViewVerdict::kBlurred;
  if (is_full()) return ViewVerdict::kAlike;
  if (!options_.keep_all && IsAlike(view)) {
    ++alike_;
    return ViewVerdict::kAlike;
  }
  coverage_.Add(view);
  tilted_ += Foreshortening(view) > kTilted ? 1 : 0;
  views_.push_back(std::move(view));
  reloads_.push_back(std::move(reload));
  return ViewVerdict::kTaken;
}

bool ViewCollector::IsBlurred(const LensView& view) const {
  std::vector<double> widths;
  for (const LensView& taken : views_)
    if (taken.edge_px > 0) widths.push_back(taken.edge_px);
  if (widths.empty() || view.edge_px == 0) return false;
  const auto sharp = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 4);
  std::nth_element(widths.begin(), sharp, widths.end());
  return view.edge_px > std::max(kBlurRatio * *sharp, kSharpPx);
}

bool ViewCollector::IsAlike(const LensView& view) const {
  using Key = std::tuple<int, double, double>;
  std::map<Key, Eigen::Vector2d> here;
  for (const SeenPoint& point : view.points)
    here[{point.board, point.on_board_m.x(), point.on_board_m.y()}] = point.pixel;
  return std::any_of(views_.begin(), views_.end(), [&](const LensView& taken) {
    double sum = 0, moves = 0, spread = 0;
    Eigen::Vector2d move = Eigen::Vector2d::Zero(), middle = Eigen::Vector2d::Zero();
    std::size_t common = 0;
    for (const SeenPoint& point : taken.points) {
      const auto same = here.find({point.board, point.on_board_m.x(), point.on_board_m.y()});
      if (same == here.end()) continue;
      const Eigen::Vector2d moved = same->second - point.pixel;
      sum += moved.norm();
      move += moved, moves += moved.squaredNorm();
      middle += point.pixel, spread += point.pixel.squaredNorm();
      ++common;
    }
    // New points are news.
    if (2 * common < here.size()) return false;
    const auto count = static_cast<double>(common);
    const double shape = moves - move.squaredNorm() / count;
    return sum / count < kAlikeShare * options_.width &&
           shape < kAlikeShape * kAlikeShape * (spread - middle.squaredNorm() / count);
  });
}

std::string ViewCollector::Hint(ViewVerdict last) const {
  if (last == ViewVerdict::kNothingSeen) return "the target is not seen";
  if (last == ViewVerdict::kBlurred) return "blurred: hold it still, or give more light";
  const std::string lacking = Lacking();
  return lacking.empty() ? "enough" : lacking;
}

std::string ViewCollector::Lacking() const {
  if (const std::string where = coverage_.Where(); !where.empty()) return "hold it into the " + where;
  if (tilted_ < 8) return "tilt it by 20 to 45 degrees";
  return {};
}

}  // namespace chequer
