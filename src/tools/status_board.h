#pragma once

#include <chrono>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/clock.h"
#include "publish/messages.h"
#include "tools/recent_map.h"

namespace chequer {

/// What is wrong with a camera's service, in words; empty where it does what it is for. Warnings about the quality of
/// what is seen are nothing wrong with the service. @param age since the status came.
std::string Trouble(const StatusMessage& status, std::chrono::microseconds age);

/// Why markers are not read, as the daemon sees it, in words: black, blurred, another variant, off the floor; a line
/// each. None is wrong with the service.
std::vector<std::string> HintsOf(const StatusMessage& status);

/// Warnings about the quality of what is seen with the share of markers that carry each, such as "poor_illumination
/// 12 %"; empty where there is none.
std::string QualityRemark(const StatusMessage& status);

/// The newest status of each daemon that is heard, for `chequer status`: of each camera, and of each where several
/// daemons publish as one. One thread.
class StatusBoard {
 public:
  struct Key {
    std::string channel;
    std::uint64_t instance = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Entry {
    StatusMessage status;
    MonotonicTime first{};    ///< when it was first heard
    MonotonicTime arrived{};  ///< and last
  };
  /// One line of the board.
  struct Row {
    Key key;
    Entry entry;
    std::string trouble;  ///< empty where it does what it is for
  };

  /// @param name of the only camera of interest; empty: all.
  explicit StatusBoard(std::string name) : name_(std::move(name)) {}

  void Add(const std::string& channel, const StatusMessage& status, MonotonicTime now);

  bool IsEmpty() const { return entries_.empty(); }
  /// Names of cameras that were heard and are of no interest, each once.
  std::vector<std::string> OthersHeard() const { return {others_.begin(), others_.end()}; }
  /// Those that are there, by channel. A daemon that was silent since another of its channel began is not: it was
  /// started again.
  std::vector<Row> Rows(MonotonicTime now) const;
  /// Whether every camera that was heard does what it is for.
  bool AllWell(MonotonicTime now) const;

  /// A table, one line a daemon, then what is wrong with each or remarkable.
  std::string Text(MonotonicTime now) const;

 private:
  /// More than anybody has; a bound for what may come from the network.
  static constexpr std::size_t kMaxEntries = 256;

  std::string name_;
  RecentMap<Key, Entry> entries_{kMaxEntries};
  std::set<std::string> others_;
};

}  // namespace chequer
