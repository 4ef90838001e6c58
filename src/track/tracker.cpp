#include "track/tracker.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace chequer {
namespace {

// What is reckoned with before a second pose tells; so wide that any robot's first step is believed.
constexpr double kUnknownSpeed = 3;     // m/s
constexpr double kUnknownTurning = 20;  // rad/s

/// A robot is known by its name alone: of its two markers a frame may show either.
bool Before(const TrackKey& a, const TrackKey& b) {
  if (!a.robot.empty() || !b.robot.empty()) return a.robot < b.robot;
  return std::tie(a.family, a.id) < std::tie(b.family, b.id);
}

/// What of a pose's error is another in every frame. A filter takes it for all there is, and its state for the pose
/// with the print's error, which its covariance leaves out.
Matrix6d Varying(const TrackedPose& pose) { return pose.covariance - pose.print_covariance; }

bool IsUsable(const TrackedPose& pose) {
  return pose.frame_from_body.translation.allFinite() && pose.frame_from_body.rotation.coeffs().allFinite() &&
         pose.covariance.allFinite() && pose.print_covariance.allFinite() &&
         (Varying(pose).diagonal().array() > 0).all();
}

double Seconds(std::chrono::microseconds time) { return std::chrono::duration<double>(time).count(); }

ConstantVelocity Begin(const TrackedPose& pose) {
  return {pose.frame_from_body, Varying(pose), kUnknownSpeed, kUnknownTurning};
}

}  // namespace

std::string TrackerOptions::Check() const {
  if (!(model.acceleration_m_s2 >= 0.001 && model.acceleration_m_s2 <= 1000))
    return "acceleration: must be from 0.001 to 1000 m/s^2";
  if (!(model.angular_acceleration_rad_s2 >= 0.001 && model.angular_acceleration_rad_s2 <= 10000))
    return "angular_acceleration: must be from 0.001 to 10000 rad/s^2";
  if (!(gate >= 2 && gate <= 100)) return "gate: must be from 2 to 100 standard deviations";
  if (coast < std::chrono::milliseconds(10) || coast > std::chrono::seconds(60))
    return "coast: must be from 0.01 to 60 s";
  if (refused_to_restart < 2 || refused_to_restart > 1000) return "refused_to_restart: must be from 2 to 1000";
  return "";
}

Tracker::Tracker(TrackerOptions options) : options_(options) {
  if (const std::string wrong = options_.Check(); !wrong.empty()) throw std::runtime_error(wrong);
}

std::vector<Tracker::Track>::iterator Tracker::PlaceOf(const TrackKey& key) {
  return std::lower_bound(tracks_.begin(), tracks_.end(), key,
                          [](const Track& track, const TrackKey& sought) { return Before(track.key, sought); });
}

Tracker::Track* Tracker::Find(const TrackKey& key) {
  const auto place = PlaceOf(key);
  return place == tracks_.end() || Before(key, place->key) ? nullptr : &*place;
}

void Tracker::Update(std::span<const TrackedPose> poses, MonotonicTime captured) {
  if (time_ && captured < *time_) tracks_.clear();
  const double step = time_ && captured > *time_ ? Seconds(captured - *time_) : 0;
  time_ = captured;
  std::erase_if(tracks_, [&](const Track& track) { return captured - track.last_seen > options_.coast; });
  for (Track& track : tracks_) {
    track.filter.Predict(step, options_.model);
    if (track.elsewhere) track.elsewhere->Predict(step, options_.model);
  }
  std::vector<const TrackedPose*> nearest(tracks_.size(), nullptr);
  std::vector<TrackedPose> strangers;
  for (const TrackedPose& pose : poses) {
    if (!IsUsable(pose)) continue;
    Track* track = Find(pose.key);
    if (track == nullptr) {
      strangers.push_back(pose);
      continue;
    }
    const TrackedPose*& best = nearest[static_cast<std::size_t>(track - tracks_.data())];
    const auto distance = [&](const TrackedPose& p) { return track->filter.Distance(p.frame_from_body, p.covariance); };
    if (best == nullptr || distance(pose) < distance(*best)) best = &pose;
  }
  for (std::size_t i = 0; i < nearest.size(); ++i)
    if (nearest[i] != nullptr) Take(tracks_[i], *nearest[i]);
  for (const TrackedPose& pose : strangers) {
    if (Find(pose.key) != nullptr) continue;  // twice in its first frame
    tracks_.insert(PlaceOf(pose.key), Track{pose.key, Begin(pose), pose.print_covariance, captured, captured});
  }
}

void Tracker::Take(Track& track, const TrackedPose& pose) {
  const double distance = track.filter.Distance(pose.frame_from_body, pose.covariance);
  if (!(distance <= options_.gate)) return Refuse(track, pose);
  track.filter.Correct(pose.frame_from_body, Varying(pose));
  track.print_covariance = pose.print_covariance;
  track.last_seen = *time_;
  ++track.poses_used;
  track.refused_on_end = 0;
  track.elsewhere.reset();
}

void Tracker::Refuse(Track& track, const TrackedPose& pose) {
  ++track.poses_refused;
  const bool agrees =
      track.elsewhere && track.elsewhere->Distance(pose.frame_from_body, pose.covariance) <= options_.gate;
  if (!agrees) {
    track.elsewhere = Begin(pose);
    track.refused_on_end = 1;
    return;
  }
  track.elsewhere->Correct(pose.frame_from_body, Varying(pose));
  if (++track.refused_on_end < options_.refused_to_restart) return;
  track = Track{track.key, *track.elsewhere, pose.print_covariance, *time_, *time_, 1, track.poses_refused};
}

void Tracker::Tracks(MonotonicTime at, std::vector<TrackState>& tracks) const {
  tracks.clear();
  if (!time_) return;
  const double ahead = at > *time_ ? Seconds(at - *time_) : 0;
  for (const Track& track : tracks_) {
    ConstantVelocity filter = track.filter;
    if (ahead > 0) filter.Predict(ahead, options_.model);
    const MonotonicTime then = std::max(at, *time_);
    TrackState state;
    state.key = track.key;
    state.frame_from_body = {Canonical(filter.pose().rotation), filter.pose().translation};
    state.velocity = filter.velocity();
    state.angular_velocity = filter.angular_velocity();
    state.covariance = filter.covariance();
    state.covariance.topLeftCorner<6, 6>() += track.print_covariance;
    state.age = then - track.first_seen;
    state.since_seen = then - track.last_seen;
    state.coasting = track.last_seen < *time_;
    state.poses_used = track.poses_used;
    state.poses_refused = track.poses_refused;
    tracks.push_back(std::move(state));
  }
}

}  // namespace chequer
