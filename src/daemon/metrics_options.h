#pragma once

#include <cstdint>
#include <filesystem>

namespace chequer {

/// How the figures of status_t are offered to Prometheus. Nothing unless asked for.
struct MetricsOptions {
  std::uint16_t port = 0;      ///< of 127.0.0.1, at /metrics; 0: no endpoint
  std::filesystem::path file;  ///< written anew with each status; empty: none
};

}  // namespace chequer
