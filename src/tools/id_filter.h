#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "publish/lcm_subscriber.h"

namespace chequer {

/// Leaves of messages what bears one of some ids.
class IdFilter {
 public:
  /// @param list such as "0-9,17". Throws CLI::ValidationError where it is anything else; empty: no id.
  explicit IdFilter(const std::string& list);

  /// Takes other markers, robots and tracks out of a message; a status stays as it is.
  void Keep(ReceivedMessage& message) const;

 private:
  std::set<std::uint64_t> ids_;
};

}  // namespace chequer
