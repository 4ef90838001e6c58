#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace chequer {

/// LCM's multicast group, not leaving this host.
inline constexpr std::string_view kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0";

enum class LcmProvider { kUdpMulticast, kTcpQueue, kFile, kMemory };

/// An LCM URL, `provider://network?name=value&name=value`, whose parts are known to be right.
struct LcmUrl {
  std::string text;  ///< the whole of it, as LCM is given it
  LcmProvider provider = LcmProvider::kUdpMulticast;
  std::string address;     ///< udpm, tcpq: four numbers with dots
  std::uint16_t port = 0;  ///< udpm, tcpq
  std::string path;        ///< file
  std::map<std::string, std::string> arguments;

  /// Whether messages go to other hosts: multicast with a ttl of 1 or more, a server elsewhere.
  bool LeavesTheHost() const;
};

/// What the URL is for: a log file is written by the one and read by the other.
enum class LcmDirection { kPublish, kSubscribe };

/// Understands a URL. Throws std::runtime_error naming the URL, what is wrong with it and what would be right.
/// Stricter than LCM, which prints a warning and goes on with port 0, an address that is no multicast group, or an
/// argument it does not know.
LcmUrl ParseLcmUrl(std::string_view text, LcmDirection direction);

/// Whether LCM can be opened there now: empty, or what is missing, naming the URL and the remedy. LCM itself prints
/// many lines on standard error each time it is asked in vain; asking first keeps a daemon that waits quiet. Nothing is
/// asked of files.
std::string ProbeLcmUrl(const LcmUrl& url);

/// What to say where an LCM TCP server cannot be reached: the URL, why, and the remedy.
std::string TcpqComplaint(const LcmUrl& url, const std::string& why);

}  // namespace chequer
