#include "bench/peer.h"

#include <dlfcn.h>

#include <algorithm>
#include <stdexcept>

namespace chequer::bench {
namespace {

constexpr char kEntry[] = "chequer_peer";
constexpr int kMinCells = 3;
constexpr int kMaxCells = 64;

/// What is wrong with what a library says of itself, or nothing.
std::string Fault(const ChequerPeer* plugin) {
  const auto empty = [](const char* text) { return text == nullptr || *text == '\0'; };
  if (plugin == nullptr) return std::string(kEntry) + " returns nothing";
  if (plugin->abi != CHEQUER_PEER_ABI)
    return "is made for version " + std::to_string(plugin->abi) + " of peer_plugin.h; this is version " +
           std::to_string(CHEQUER_PEER_ABI);
  if (empty(plugin->name) || empty(plugin->pattern)) return "must give its name and its pattern";
  if (plugin->create == nullptr || plugin->destroy == nullptr || plugin->detect == nullptr)
    return "must have create, destroy and detect";
  if (plugin->draw == nullptr) return "";
  if (plugin->cells < kMinCells || plugin->cells > kMaxCells)
    return "draws boards of " + std::to_string(plugin->cells) + " cells; must be " + std::to_string(kMinCells) +
           " to " + std::to_string(kMaxCells);
  if (plugin->rim < 0 || 2 * plugin->rim >= plugin->cells)
    return "leaves no cells within a rim of " + std::to_string(plugin->rim);
  if (plugin->ids < 1) return "has no ids";
  return "";
}

Board DrawnBy(const ChequerPeer& plugin, std::uint64_t number) {
  const auto side = static_cast<std::size_t>(plugin.cells);
  const std::uint64_t id = number % static_cast<std::uint64_t>(plugin.ids);
  std::vector<std::uint8_t> white(side * side);
  plugin.draw(static_cast<int>(id), white.data());
  Board board{.rows = plugin.cells,
              .cols = plugin.cells,
              .cells = {},
              .uncounted_rim = plugin.rim,
              .id = id,
              .variant = plugin.pattern};
  for (const std::uint8_t cell : white) board.cells += cell == 0 ? 'K' : 'W';
  return board;
}

}  // namespace

void Peer::Unload::operator()(void* library) const { dlclose(library); }

Peer::Peer(const std::filesystem::path& library) {
  // A bare name would be looked for in the system's folders alone.
  library_.reset(dlopen(std::filesystem::absolute(library).c_str(), RTLD_NOW | RTLD_LOCAL));
  if (!library_)
    throw std::runtime_error(std::string(dlerror()) + "; must be a shared library with peer_plugin.h's " + kEntry);
  const auto entry = reinterpret_cast<const ChequerPeer* (*)()>(dlsym(library_.get(), kEntry));
  if (entry == nullptr)
    throw std::runtime_error(library.string() + ": has no function " + kEntry +
                             "; peer_plugin.h tells what it must be");
  plugin_ = entry();
  if (const std::string fault = Fault(plugin_); !fault.empty())
    throw std::runtime_error(library.string() + ": " + fault);
}

std::optional<Print> Peer::print() const {
  if (plugin_->draw == nullptr) return std::nullopt;
  return Print{pattern(), [plugin = plugin_](std::uint64_t number) { return DrawnBy(*plugin, number); }};
}

std::vector<Print> PrintsWith(const std::vector<Peer>& peers) {
  std::vector<Print> prints = KnownPrints();
  const auto drawn = [&prints](const Pattern& pattern) {
    return std::any_of(prints.begin(), prints.end(), [&](const Print& print) { return print.pattern == pattern; });
  };
  for (const Peer& peer : peers) {
    // Two settings of one detector are two peers with the same markers.
    if (drawn(peer.pattern())) continue;
    if (const std::optional<Print> print = peer.print()) prints.push_back(*print);
  }
  for (const Peer& peer : peers) {
    if (drawn(peer.pattern())) continue;
    std::string known;
    for (const Print& print : prints) known += (known.empty() ? "" : ", ") + print.pattern;
    throw std::runtime_error(peer.name() + " reads \"" + peer.pattern() + "\", which nobody draws; there are " + known);
  }
  return prints;
}

}  // namespace chequer::bench
