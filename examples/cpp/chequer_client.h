#pragma once

#include <atomic>
#include <chequer/poses_t.hpp>
#include <chequer/robots_t.hpp>
#include <chequer/tracks_t.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

// A client of chequerd to copy into programs of your own. Needs LCM and the C++ that chequer_lcm_gen.py makes of
// chequer's lcmtypes, whose decoders refuse messages that lie about their length.

namespace chequer::client {

/// What arrives of one robot, one marker, or of whole messages: the latest, the new, the next. Any thread.
template <typename Value>
class Target {
 public:
  /// What came last; nothing before the first. Does not wait.
  std::optional<Value> Latest() {
    const std::lock_guard lock(mutex_);
    given_ = arrived_;
    return value_;
  }

  /// What this target was not asked for yet: at once if there is such, else when it comes. Nothing after the time.
  std::optional<Value> New(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    return WaitBeyond(given_, timeout, lock);
  }

  /// What arrives after the call. Nothing after the time.
  std::optional<Value> Next(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    return WaitBeyond(arrived_, timeout, lock);
  }

  /// For the client: something arrived.
  void Put(Value value) {
    {
      const std::lock_guard lock(mutex_);
      value_ = std::move(value);
      ++arrived_;
    }
    changed_.notify_all();
  }

 private:
  std::optional<Value> WaitBeyond(std::uint64_t count, std::chrono::milliseconds timeout,
                                  std::unique_lock<std::mutex>& lock) {
    if (!changed_.wait_for(lock, timeout, [&] { return arrived_ > count; })) return std::nullopt;
    given_ = arrived_;
    return value_;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Value> value_;
  std::uint64_t arrived_ = 0;  ///< values so far
  std::uint64_t given_ = 0;    ///< of them, the last one that was asked for
};

/// Listens on a thread of its own once Start was called.
class Client {
 public:
  /// @param prefix of the daemon's channels, such as CHEQUER_ceiling. @param url of LCM; empty: LCM_DEFAULT_URL, else
  /// LCM's default. Throws std::runtime_error where LCM cannot be opened (no multicast route).
  explicit Client(std::string prefix, const std::string& url = {}) : prefix_(std::move(prefix)), lcm_(url) {
    if (!lcm_.good())
      throw std::runtime_error("LCM cannot be opened; without a network: ip route add 224.0.0.0/4 dev lo");
  }
  ~Client() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// The track of a robot of the roster; targets must be there before Start and as long as the client.
  void WatchTrack(const std::string& robot, Target<chequer::track_t>& target) {
    Watch<chequer::tracks_t>("_TRACKS", [&target, robot](const chequer::tracks_t& message) {
      for (const chequer::track_t& track : message.tracks)
        if (track.name == robot) target.Put(track);
    });
  }

  /// The raw pose of a marker.
  void WatchMarker(std::uint64_t id, Target<chequer::marker_pose_t>& target) {
    Watch<chequer::poses_t>("_POSES", [&target, id](const chequer::poses_t& message) {
      for (const chequer::marker_pose_t& marker : message.markers)
        if (marker.id_valid != 0 && static_cast<std::uint64_t>(marker.id) == id) target.Put(marker);
    });
  }

  /// Whole messages, with their times.
  void WatchTracks(Target<chequer::tracks_t>& target) {
    Watch<chequer::tracks_t>("_TRACKS", [&target](const chequer::tracks_t& message) { target.Put(message); });
  }
  void WatchPoses(Target<chequer::poses_t>& target) {
    Watch<chequer::poses_t>("_POSES", [&target](const chequer::poses_t& message) { target.Put(message); });
  }

  void Start() {
    thread_ = std::thread([this] {
      while (!stopping_ && lcm_.handleTimeout(100) >= 0) {
      }
    });
  }

  /// For sending; any thread.
  lcm::LCM& lcm() { return lcm_; }

 private:
  template <typename Message>
  struct Handler {
    std::function<void(const Message&)> take;
    void On(const lcm::ReceiveBuffer* /*buffer*/, const std::string& /*channel*/, const Message* message) {
      take(*message);
    }
  };

  template <typename Message>
  void Watch(const std::string& suffix, std::function<void(const Message&)> take) {
    auto handler = std::make_shared<Handler<Message>>(Handler<Message>{std::move(take)});
    lcm_.subscribe(prefix_ + suffix, &Handler<Message>::On, handler.get());
    handlers_.push_back(std::move(handler));
  }

  std::string prefix_;
  std::vector<std::shared_ptr<void>> handlers_;  ///< of several types, so shared_ptr; LCM only borrows them
  lcm::LCM lcm_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace chequer::client
