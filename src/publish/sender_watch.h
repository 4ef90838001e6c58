#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/clock.h"
#include "publish/lcm_url.h"
#include "publish/sender_claim.h"
#include "publish/status_listener.h"

namespace chequer {

/// Notices other daemons that publish as the same camera: those on this host, and where messages leave the host, those
/// elsewhere too. Else it opens no socket of the network: nobody can send it anything. One thread.
class SenderWatch {
 public:
  /// @param instance of this process.
  SenderWatch(const LcmUrl& url, const std::string& prefix, std::uint64_t instance);

  /// What is wrong and what would help, where another sender was heard within the last seconds; else empty. To be
  /// called about once a second.
  std::string Look(MonotonicTime now);

 private:
  /// What tells that another is there: its address, or that it is on this host.
  struct Sign {
    int seen = 0;  ///< times on end
    MonotonicTime last{};
  };
  void Note(const std::string& where, MonotonicTime now);

  std::string prefix_;
  std::uint64_t instance_;
  std::optional<StatusListener> listener_;  ///< where messages leave the host
  SenderClaim claim_;
  std::map<std::string, Sign> signs_;
};

}  // namespace chequer
