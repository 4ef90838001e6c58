#pragma once

#include <chrono>
#include <map>
#include <string>

#include "core/clock.h"
#include "publish/messages.h"

namespace chequer {

/// What is wrong with a camera's service, in words; empty where it does what it is for. Warnings about the quality of
/// what is seen are nothing wrong with the service. @param age since the status came.
std::string Trouble(const StatusMessage& status, std::chrono::microseconds age);

/// Warnings about the quality of what is seen with the share of markers that carry each, such as "poor_illumination
/// 12 %"; empty where there is none.
std::string QualityRemark(const StatusMessage& status);

/// The newest status of each camera that is heard, for `chequer status`. One thread.
class StatusBoard {
 public:
  struct Entry {
    StatusMessage status;
    MonotonicTime arrived{};
  };

  /// @param name of the only camera of interest; empty: all.
  explicit StatusBoard(std::string name) : name_(std::move(name)) {}

  void Add(const std::string& channel, const StatusMessage& status, MonotonicTime now);

  bool IsEmpty() const { return entries_.empty(); }
  /// Whether every camera that was heard does what it is for.
  bool AllWell(MonotonicTime now) const;
  /// By channel.
  const std::map<std::string, Entry>& entries() const { return entries_; }

  /// A table, one line a camera, then what is wrong with each or remarkable.
  std::string Text(MonotonicTime now) const;

 private:
  std::string name_;
  std::map<std::string, Entry> entries_;
};

}  // namespace chequer
