#include "detect/memory/memory.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// After a longer time, boards are no longer where their motion would take them: robots brake and turn within it.
constexpr double kLongestGapS = 0.25;
/// A place where something was lost or could not be read is searched in every frame for so long; then in its turn.
constexpr double kOpenS = 1;
/// Simple traits are asked for again after so many frames: the lens and the prints change little in so short a time (a
/// guess). Asked in every frame, a board alone takes 1.4 times as much.
constexpr int kTraitsFrames = 16;

}  // namespace

DetectorMemory::DetectorMemory() : state_(std::make_unique<MemoryState>()) {}
DetectorMemory::~DetectorMemory() = default;
DetectorMemory::DetectorMemory(const DetectorMemory& other) : state_(std::make_unique<MemoryState>(*other.state_)) {}
DetectorMemory& DetectorMemory::operator=(const DetectorMemory& other) {
  if (this == &other) return *this;
  if (!state_) state_ = std::make_unique<MemoryState>();
  *state_ = *other.state_;
  return *this;
}
DetectorMemory::DetectorMemory(DetectorMemory&&) noexcept = default;
DetectorMemory& DetectorMemory::operator=(DetectorMemory&&) noexcept = default;

void DetectorMemory::Clear() { state_->Clear(); }
std::size_t DetectorMemory::boards() const { return state_->boards.size(); }
std::size_t DetectorMemory::bytes() const {
  return sizeof(MemoryState) + state_->boards.size() * sizeof(RememberedBoard) +
         state_->open.size() * sizeof(OpenPlace);
}

void MemoryState::Clear() {
  filled = false;
  interval_s = 0;
  since_start = 0;
  since_search = {};
  boards.clear();
  open.clear();
  dot_gain = 0;
  edge_tally = {};
  simple_traits.reset();
  traits_age = 0;
}

int MemoryState::Continue(FrameTime now, int frame_width, int frame_height) {
  const double passed_s = Seconds(now - captured);
  if (!filled || !(passed_s > 0) || passed_s > kLongestGapS || frame_width != width || frame_height != height) {
    Clear();
    width = frame_width;
    height = frame_height;
    return 1;
  }
  interval_s = interval_s > 0 ? std::min(interval_s, passed_s) : passed_s;
  return std::max(1, static_cast<int>(std::lround(passed_s / interval_s)));
}

bool MemoryState::HasTurn(int band, int bands, int every, int frames_on) const {
  const int turn = (since_start + frames_on) % every;
  if (turn * bands / every == band && turn * bands % every < bands) return true;
  return since_search[static_cast<std::size_t>(band)] + frames_on >= 2 * every;
}

std::optional<ImageTraits> MemoryState::TraitsAhead(int frames_on) const {
  return traits_age + frames_on < kTraitsFrames ? simple_traits : std::nullopt;
}

void MemoryState::Learn(const Lesson& lesson, std::vector<RememberedBoard>& read) {
  filled = true;
  captured = lesson.now;
  since_start += lesson.frames_on;
  for (std::size_t band = 0; band < since_search.size(); ++band)
    since_search[band] = lesson.searched[band] ? 0 : since_search[band] + lesson.frames_on;
  if (read.size() > DetectorMemory::kMostBoards) read.resize(DetectorMemory::kMostBoards);
  boards.swap(read);
  // What was open before stays so for a time, unless it has been read by now or is open anew.
  const auto lies_in = [](const PixelBox& box, const PixelBox& place) {
    const Eigen::Vector2f middle = box.Center();
    return middle.x() > place.left && middle.x() < place.right && middle.y() > place.top && middle.y() < place.bottom;
  };
  std::erase_if(open, [&](const OpenPlace& place) {
    return Seconds(captured - place.since) > kOpenS ||
           std::any_of(boards.begin(), boards.end(),
                       [&](const RememberedBoard& board) { return lies_in(board.box, place.box); }) ||
           std::any_of(lesson.open.begin(), lesson.open.end(),
                       [&](const PixelBox& box) { return lies_in(box, place.box); });
  });
  for (const PixelBox& box : lesson.open)
    if (open.size() < DetectorMemory::kMostBoards) open.push_back({box, captured});
  const FrameTime for_a_frame = captured - std::chrono::duration_cast<FrameTime>(std::chrono::duration<double>(kOpenS));
  for (const PixelBox& box : lesson.cut)
    if (open.size() < DetectorMemory::kMostBoards) open.push_back({box, for_a_frame});
}

void RememberedBoard::Move(const RememberedBoard* last, const Eigen::Matrix3d& last_place, const Eigen::Matrix3d& now,
                           double passed_s) {
  motion.before_s = last ? passed_s : 0;
  motion.before = last_place;
  plane_from_board = now;
}

}  // namespace chequer
