#pragma once

#include <cstdint>
#include <string>

#include "core/unique_fd.h"

namespace chequer {

/// Tells the processes of one host that send for the same thing of each other, without a network: the service's sandbox
/// lets multicast out, but not back in where the host has a network. The first holds a name (an abstract socket), the
/// others tell it of themselves. One thread.
class SenderClaim {
 public:
  /// @param what two processes must not both send for. @param instance of this process.
  SenderClaim(const std::string& what, std::uint64_t instance);

  /// Whether another process was there since the last call. To be called about once a second.
  bool SeesAnother();

 private:
  void Claim();
  bool Hears();

  std::string name_;
  std::uint64_t instance_;
  UniqueFd socket_;
  bool is_holder_ = false;
};

}  // namespace chequer
