#include "tools/log_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <stdexcept>
#include <variant>

#include "core/file.h"
#include "core/printable.h"
#include "publish/lcm_log.h"
#include "tools/plot.h"

namespace chequer {
namespace {

constexpr int kMovesWidth = 1280, kMovesHeight = 640;
constexpr double kMovesLetters = 13;
/// Colours repeat after that; more names would not be told apart.
constexpr std::size_t kMostNamed = 8;
constexpr Ink kMovesText{0.1, 0.1, 0.1};

std::string TrackName(const TrackKey& key) { return key.robot.empty() ? fmt::format("id {}", key.id) : key.robot; }

/// A square around all ways, so that a metre is as long both ways.
Eigen::AlignedBox2d SquareAround(const MoveCollector& moves) {
  Eigen::AlignedBox2d box;
  for (const auto& [name, way] : moves.moves())
    for (const PlottedMove& move : way) box.extend(move.position_m);
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(std::max(0.55 * box.sizes().maxCoeff(), 0.05));
  return {box.center() - half, box.center() + half};
}

void DrawWays(Canvas& canvas, const MoveCollector& moves, const PlotArea& area) {
  const bool seen_by_camera = moves.frame() == "camera";
  DrawAxes(canvas, area,
           {.title = seen_by_camera ? "Ways, as the camera sees them" : "Ways, from above",
            .x_label = "x, m",
            .y_label = seen_by_camera ? "-y, m" : "y, m",
            .size = kMovesLetters});
  canvas.Clip(area.left, area.top, area.width, area.height);
  std::size_t index = 0;
  for (const auto& [name, way] : moves.moves()) {
    const Ink ink = SeriesInk(index++);
    std::vector<Eigen::Vector2d> points;
    for (const PlottedMove& move : way) points.emplace_back(area.X(move.position_m.x()), area.Y(move.position_m.y()));
    canvas.Polyline(points, ink, 1.5);
    canvas.Disc(points.back().x(), points.back().y(), 4, ink);
    if (index <= kMostNamed)
      canvas.Text(Printable(name), points.back().x() + 7, points.back().y() + 4, kMovesLetters, kMovesText);
  }
  canvas.EndClip();
}

void DrawSpeeds(Canvas& canvas, const MoveCollector& moves, PlotArea area) {
  area.x_most = area.y_most = 0;
  for (const auto& [name, way] : moves.moves())
    for (const PlottedMove& move : way) {
      area.x_most = std::max(area.x_most, move.time_s);
      area.y_most = std::max(area.y_most, move.speed_m_s);
    }
  area.x_most = std::max(area.x_most, 1e-3);
  area.y_most = std::max(1.1 * area.y_most, 1e-3);
  DrawAxes(canvas, area, {.title = "Speeds", .x_label = "s", .y_label = "m/s", .size = kMovesLetters});
  canvas.Clip(area.left, area.top, area.width, area.height);
  std::size_t index = 0;
  for (const auto& [name, way] : moves.moves()) {
    std::vector<Eigen::Vector2d> points;
    for (const PlottedMove& move : way) points.emplace_back(area.X(move.time_s), area.Y(move.speed_m_s));
    canvas.Polyline(points, SeriesInk(index++), 1.5);
  }
  canvas.EndClip();
}

/// Which stream of a log is drawn: the one with velocities, if it is there.
MoveCollector CollectMoves(const std::filesystem::path& log, LogStream stream) {
  if (stream != LogStream::kAll) {
    MoveCollector moves(stream);
    LcmLogReader reader(log);
    while (const auto record = reader.Next()) moves.Add(record->message);
    return moves;
  }
  for (const LogStream each : {LogStream::kTracks, LogStream::kRobots, LogStream::kPoses}) {
    MoveCollector moves = CollectMoves(log, each);
    if (!moves.moves().empty()) return moves;
  }
  return MoveCollector(stream);
}

}  // namespace

void MoveCollector::Add(const FrameHeader& header, const std::string& name, const RigidTransform& pose,
                        const double* speed_m_s) {
  if (!first_) first_ = header.captured_monotonic;
  frame_ = header.frame;
  PlottedMove move;
  move.time_s = std::chrono::duration<double>(header.captured_monotonic - *first_).count();
  move.position_m = pose.translation.head<2>();
  if (frame_ == "camera") move.position_m.y() *= -1;
  std::vector<PlottedMove>& way = moves_[name];
  if (speed_m_s != nullptr)
    move.speed_m_s = *speed_m_s;
  else if (!way.empty() && move.time_s > way.back().time_s)
    move.speed_m_s = (move.position_m - way.back().position_m).norm() / (move.time_s - way.back().time_s);
  way.push_back(move);
}

void MoveCollector::Add(const ReceivedMessage& message) {
  if (const auto* tracks = std::get_if<TracksMessage>(&message); tracks != nullptr && stream_ == LogStream::kTracks)
    for (const TrackState& track : tracks->tracks) {
      const double speed_m_s = track.velocity.norm();
      Add(tracks->header, TrackName(track.key), track.frame_from_body, &speed_m_s);
    }
  if (const auto* robots = std::get_if<RobotsMessage>(&message); robots != nullptr && stream_ == LogStream::kRobots)
    for (const RobotPose& robot : robots->robots) Add(robots->header, robot.name, robot.frame_from_body, nullptr);
  if (const auto* poses = std::get_if<PosesMessage>(&message); poses != nullptr && stream_ == LogStream::kPoses)
    for (const MarkerPose& marker : poses->markers)
      if (marker.id && marker.has_pose)
        Add(*poses, fmt::format("id {}", *marker.id), marker.camera_from_marker, nullptr);
}

std::vector<std::uint8_t> DrawMoves(const MoveCollector& moves) {
  Canvas canvas = Canvas::Png(kMovesWidth, kMovesHeight);
  const Eigen::AlignedBox2d box = SquareAround(moves);
  constexpr double kSquare = kMovesHeight - 130;
  DrawWays(canvas, moves,
           {.left = 80,
            .top = 50,
            .width = kSquare,
            .height = kSquare,
            .x_least = box.min().x(),
            .x_most = box.max().x(),
            .y_least = box.min().y(),
            .y_most = box.max().y()});
  DrawSpeeds(canvas, moves,
             {.left = 180 + kSquare, .top = 50, .width = kMovesWidth - kSquare - 210, .height = kSquare});
  return canvas.Finish();
}

void PlotLog(const std::filesystem::path& log, const std::filesystem::path& out, LogStream stream) {
  const MoveCollector moves = CollectMoves(log, stream);
  if (moves.moves().empty())
    throw std::runtime_error(log.string() +
                             " holds no poses of chequer's to draw; markers without a calibration have none");
  WriteFileAtomically(out, DrawMoves(moves));
}

}  // namespace chequer
