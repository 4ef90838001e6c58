#include "bench/race.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "bench/contestants.h"

namespace chequer::bench {
namespace {

/// Reads a frame, so that everyone finds it in the caches, as one that has just been captured, and not only those who
/// come after another that reads the same.
void Warm(const BenchFrame& frame) {
  constexpr std::size_t kLine = 64;
  volatile std::uint8_t last = 0;
  const auto read = [&last](const Image& image) {
    for (std::size_t i = 0; i < image.bytes().size(); i += kLine) last = image.bytes()[i];
  };
  read(frame.colour);
  if (frame.bayer) read(*frame.bayer);
}

/// One contestant's frames, scores and times.
class Lane {
 public:
  Lane(std::unique_ptr<Contestant> contestant, const Suite& suite)
      : suite_(&suite), contestant_(std::move(contestant)), total_(suite.camera) {
    // Photographs without markers serve all; they are kept once.
    const Pattern pattern = suite.HasMarkers() ? contestant_->pattern() : suite.frames.begin()->first;
    const auto frames = suite.frames.find(pattern);
    if (frames == suite.frames.end()) return;
    for (const BenchFrame& frame : frames->second) {
      if (contestant_->Takes(frame)) frames_.push_back(&frame);
    }
  }

  std::size_t frame_count() const { return frames_.size(); }

  /// Detects in a frame, if there is one of that number, and keeps the shortest time.
  void Time(std::size_t index) {
    if (index >= frames_.size()) return;
    best_ms_.resize(frames_.size(), std::numeric_limits<double>::infinity());
    Warm(*frames_[index]);
    contestant_->Prepare(best_ms_[index] == std::numeric_limits<double>::infinity());
    const auto start = std::chrono::steady_clock::now();
    contestant_->Detect(*frames_[index]);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    best_ms_[index] = std::min(best_ms_[index], elapsed.count());
  }

  /// Scores what the last detection found. @pre it was of that frame.
  void Judge(std::size_t index) {
    if (index >= frames_.size()) return;
    const BenchFrame& frame = *frames_[index];
    const std::vector<Detection> detections = contestant_->Detections();
    total_.AddFrame(frame.truth, detections);
    if (conditions_.empty() || conditions_.back().first != frame.condition) {
      conditions_.emplace_back(frame.condition, ScoreKeeper(suite_->camera));
    }
    conditions_.back().second.AddFrame(frame.truth, detections);
  }

  Result Summary() const {
    Result result;
    result.contestant = contestant_->name();
    result.frames = static_cast<int>(frames_.size());
    result.ms = suite_->interval.count() > 0 ? MeanOfStream(best_ms_) : Median(best_ms_);
    result.total = total_.Summary();
    for (const auto& [condition, keeper] : conditions_) result.conditions.emplace_back(condition, keeper.Summary());
    return result;
  }

 private:
  const Suite* suite_;
  std::unique_ptr<Contestant> contestant_;
  std::vector<const BenchFrame*> frames_;
  std::vector<double> best_ms_;
  ScoreKeeper total_;
  std::vector<std::pair<std::string, ScoreKeeper>> conditions_;
};

std::vector<Lane> MakeLanes(const Suite& suite, const std::vector<Peer>& peers) {
  std::vector<Lane> lanes;
  if (suite.interval.count() > 0)
    for (const bool bayer : {false, true}) lanes.emplace_back(MakeChequerOfStream(suite, bayer), suite);
  lanes.emplace_back(MakeChequer(suite, false), suite);
  lanes.emplace_back(MakeChequer(suite, true), suite);
  for (const float decimate : {1.0f, 2.0f})
    for (const bool linear : {false, true}) lanes.emplace_back(MakeAprilTag(suite, decimate, linear), suite);
  lanes.emplace_back(MakeAruco(suite, false), suite);
  lanes.emplace_back(MakeAruco(suite, true), suite);
  for (const Peer& peer : peers) lanes.emplace_back(MakePeer(suite, peer), suite);
  std::erase_if(lanes, [](const Lane& lane) { return lane.frame_count() == 0; });
  return lanes;
}

}  // namespace

std::vector<Result> Race(const Suite& suite, int repetitions, const std::vector<Peer>& peers) {
  std::vector<Lane> lanes = MakeLanes(suite, peers);
  std::size_t frame_count = 0;
  for (const Lane& lane : lanes) frame_count = std::max(frame_count, lane.frame_count());
  std::size_t first = 0;  // who starts
  for (std::size_t frame = 0; frame < frame_count; ++frame) {
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      for (std::size_t turn = 0; turn < lanes.size(); ++turn) lanes[(turn + first) % lanes.size()].Time(frame);
      ++first;
    }
    for (Lane& lane : lanes) lane.Judge(frame);
  }
  std::vector<Result> results;
  for (const Lane& lane : lanes) results.push_back(lane.Summary());
  return results;
}

}  // namespace chequer::bench
