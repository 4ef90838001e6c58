#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/peer_plugin.h"
#include "bench/prints.h"

namespace chequer::bench {

/// A detector from a shared library; see peer_plugin.h.
class Peer {
 public:
  /// Loads it. Throws std::runtime_error naming the file, what is wrong with it and what would be right.
  explicit Peer(const std::filesystem::path& library);

  std::string name() const { return plugin_->name; }
  Pattern pattern() const { return plugin_->pattern; }
  /// How its markers are drawn, where it says that itself. Good as long as the peer lives.
  std::optional<Print> print() const;
  const ChequerPeer& plugin() const { return *plugin_; }

 private:
  struct Unload {
    void operator()(void* library) const;
  };

  std::unique_ptr<void, Unload> library_;
  const ChequerPeer* plugin_ = nullptr;
};

/// The known prints and those of the peers. Throws std::runtime_error where a peer reads a pattern that nobody draws,
/// listing those that are drawn.
std::vector<Print> PrintsWith(const std::vector<Peer>& peers);

}  // namespace chequer::bench
