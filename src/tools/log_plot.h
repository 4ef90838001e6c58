#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "publish/wire.h"
#include "tools/convert_log.h"

namespace chequer {

/// Where something was, and how fast.
struct PlottedMove {
  double time_s = 0;  ///< since the first frame
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double speed_m_s = 0;  ///< as a track has it; of poses and robots the way from the last one over its time
};

/// What a log says of moves, by robot or marker.
class MoveCollector {
 public:
  explicit MoveCollector(LogStream stream) : stream_(stream) {}

  /// Messages of other streams are passed over.
  void Add(const ReceivedMessage& message);

  const std::map<std::string, std::vector<PlottedMove>>& moves() const { return moves_; }
  /// "world" or "camera": of the last message.
  const std::string& frame() const { return frame_; }

 private:
  void Add(const FrameHeader& header, const std::string& name, const RigidTransform& pose, const double* speed_m_s);

  LogStream stream_;
  std::map<std::string, std::vector<PlottedMove>> moves_;
  std::string frame_;
  std::optional<MonotonicTime> first_;
};

/// A PNG: the ways from above (in the camera's frame: as the camera sees them), and the speeds over time.
/// @pre there are moves. Throws std::runtime_error where drawing fails.
std::vector<std::uint8_t> DrawMoves(const MoveCollector& moves);

/// Draws what an LCM log holds: its tracks, or else its robots, or else its poses. Throws std::runtime_error naming the
/// file where it holds none of them, or cannot be read or written.
void PlotLog(const std::filesystem::path& log, const std::filesystem::path& out, LogStream stream);

}  // namespace chequer
