#include "publish/lcm_url.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "core/file.h"
#include "core/unique_fd.h"
#include "publish/channels.h"
#include "publish/tcpq_connection.h"

namespace chequer {
namespace {

struct ProviderRule {
  std::string_view name;
  LcmProvider provider;
  std::string_view arguments;  ///< those LCM knows, comma-separated
};
constexpr std::array kProviders{
    ProviderRule{"udpm", LcmProvider::kUdpMulticast, "ttl, recv_buf_size"},
    ProviderRule{"tcpq", LcmProvider::kTcpQueue, ""},
    ProviderRule{"file", LcmProvider::kFile, "mode, speed, start_timestamp"},
    ProviderRule{"memq", LcmProvider::kMemory, ""},
};

[[noreturn]] void Refuse(std::string_view url, const std::string& why) {
  throw std::runtime_error("LCM URL '" + std::string(url) + "': " + why);
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view text, Number least, Number most) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most) return std::nullopt;
  return value;
}

bool Lists(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const std::size_t comma = list.find(", ");
    if (list.substr(0, comma) == name) return true;
    list = comma == std::string_view::npos ? std::string_view{} : list.substr(comma + 2);
  }
  return false;
}

void ParseArguments(std::string_view text, const ProviderRule& rule, LcmUrl& url) {
  while (!text.empty()) {
    const std::size_t ampersand = text.find('&');
    const std::string_view argument = text.substr(0, ampersand);
    text = ampersand == std::string_view::npos ? std::string_view{} : text.substr(ampersand + 1);
    const std::size_t equals = argument.find('=');
    const std::string_view name = argument.substr(0, equals);
    if (!Lists(rule.arguments, name))
      Refuse(url.text, "unknown argument '" + std::string(name) + "'; " + std::string(rule.name) +
                           (rule.arguments.empty() ? " has none" : " knows " + std::string(rule.arguments)));
    url.arguments[std::string(name)] =
        equals == std::string_view::npos ? std::string() : std::string(argument.substr(equals + 1));
  }
}

void ParseAddress(std::string_view network, const char* example, LcmUrl& url) {
  const std::size_t colon = network.find(':');
  url.address = network.substr(0, colon);
  in_addr parsed{};
  if (inet_pton(AF_INET, url.address.c_str(), &parsed) != 1)
    Refuse(url.text, "'" + url.address + "' is not an IPv4 address; right would be " + example);
  const auto port =
      colon == std::string_view::npos ? std::nullopt : ParseNumber<std::uint16_t>(network.substr(colon + 1), 1, 65535);
  if (!port) Refuse(url.text, std::string("the port, 1 to 65535, is missing or wrong; right would be ") + example);
  url.port = *port;
}

void CheckNumber(const LcmUrl& url, const char* argument, long least, long most) {
  const auto found = url.arguments.find(argument);
  if (found == url.arguments.end() || ParseNumber<long>(found->second, least, most)) return;
  Refuse(url.text, std::string(argument) + " is '" + found->second + "'; it must be a whole number from " +
                       std::to_string(least) + " to " + std::to_string(most));
}

void ParseMulticast(std::string_view network, LcmUrl& url) {
  if (network.empty()) network = "239.255.76.67:7667";  // LCM's own default
  ParseAddress(network, "udpm://239.255.76.67:7667?ttl=0", url);
  in_addr address{};
  inet_pton(AF_INET, url.address.c_str(), &address);
  if (!IN_MULTICAST(ntohl(address.s_addr)))
    Refuse(url.text, url.address + " is not a multicast group; groups are 224.0.0.0 to 239.255.255.255");
  CheckNumber(url, "ttl", 0, 255);
  CheckNumber(url, "recv_buf_size", 1, 1L << 30);
}

void ParseFile(std::string_view network, LcmDirection direction, LcmUrl& url) {
  url.path = network;
  if (url.path.empty()) Refuse(url.text, "names no file; right would be file:///var/tmp/poses.lcm?mode=w");
  const auto found = url.arguments.find("mode");
  const std::string mode = found == url.arguments.end() ? "r" : found->second;
  if (direction == LcmDirection::kPublish && mode != "w" && mode != "a")
    Refuse(url.text, "a log is only written with mode=w (anew) or mode=a (appending)");
  if (direction == LcmDirection::kSubscribe && mode != "r") Refuse(url.text, "a log is only read with mode=r");
}

sockaddr_in SocketAddress(const LcmUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  inet_pton(AF_INET, url.address.c_str(), &address.sin_addr);
  return address;
}

int Connect(int fd, const sockaddr_in& address) {
  return connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

std::string Complaint(const LcmUrl& url, const std::string& what, const std::string& remedy) {
  return "LCM at " + url.text + " cannot be opened: " + what + "; " + remedy;
}

/// The two things LCM does with a group before it sends: connecting finds a route, joining finds an interface.
std::string ProbeMulticast(const LcmUrl& url) {
  const UniqueFd probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in address = SocketAddress(url);
  ip_mreq group{};
  group.imr_multiaddr = address.sin_addr;
  if (probe.get() >= 0 && Connect(probe.get(), address) == 0 &&
      setsockopt(probe.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0)
    return {};
  return Complaint(url, std::string("no multicast route (") + std::strerror(errno) + ")",
                   "on a host without a network `ip route add 224.0.0.0/4 dev lo` gives one");
}

std::string ProbeTcp(const LcmUrl& url) {
  try {
    TcpqConnection connection(url);
    return {};
  } catch (const std::runtime_error& error) {
    return TcpqComplaint(url, error.what());
  }
}

/// Why LCM cannot write a log there without waiting; empty if it can. Opening a pipe waits for a reader, and a terminal
/// may be stopped. Other devices take what they are given (/dev/null) or say that they do not.
std::string WhyNotALog(const std::string& path) {
  const UniqueFd fd(open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0644));
  if (!fd.valid() && errno != ENXIO) return std::strerror(errno);
  struct stat status {};
  if (!fd.valid() || fstat(fd.get(), &status) != 0) return "it is a pipe, not a file";
  const bool device = S_ISCHR(status.st_mode) && isatty(fd.get()) == 0;
  return S_ISREG(status.st_mode) || device ? "" : "it is a pipe or a terminal, not a file";
}

std::string ProbeFile(const LcmUrl& url) {
  if (url.arguments.contains("mode") && url.arguments.at("mode") != "r") {
    const std::string why = WhyNotALog(url.path);
    if (why.empty()) return {};
    return Complaint(url, why, "the file " + url.path + " must be in a folder that can be written");
  }
  try {
    OpenForReading(url.path);
    return {};
  } catch (const std::runtime_error& error) {
    return Complaint(url, error.what(), "the file " + url.path + " must be readable");
  }
}

}  // namespace

bool IsValidPrefix(std::string_view prefix) {
  constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return !prefix.empty() && prefix.size() <= kMaxPrefixLength &&
         prefix.find_first_not_of(kAllowed) == std::string_view::npos;
}

bool LcmUrl::LeavesTheHost() const {
  if (provider == LcmProvider::kTcpQueue) return !address.starts_with("127.");
  if (provider != LcmProvider::kUdpMulticast) return false;
  const auto ttl = arguments.find("ttl");  // LCM's own default is 0
  return ttl != arguments.end() && ParseNumber<long>(ttl->second, 1, 255).has_value();
}

std::string DefaultPrefix(const std::string& camera_name) { return "CHEQUER_" + camera_name; }

std::string CameraNameOf(const std::filesystem::path& configuration) {
  const std::string name = configuration.stem().string();
  return IsValidPrefix(name) && name.size() <= kMaxCameraName ? name : "camera";
}

LcmUrl ParseLcmUrl(std::string_view text, LcmDirection direction) {
  LcmUrl url;
  url.text = text;
  const std::size_t separator = text.find("://");
  const auto rule = std::find_if(kProviders.begin(), kProviders.end(), [&](const ProviderRule& candidate) {
    return separator != std::string_view::npos && candidate.name == text.substr(0, separator);
  });
  if (rule == kProviders.end())
    Refuse(text, "must begin with udpm://, tcpq://, file:// or memq://, such as " + std::string(kDefaultLcmUrl));
  url.provider = rule->provider;
  const std::string_view rest = text.substr(separator + 3);
  const std::size_t question = rest.find('?');
  const std::string_view network = rest.substr(0, question);
  if (question != std::string_view::npos) ParseArguments(rest.substr(question + 1), *rule, url);
  switch (url.provider) {
    case LcmProvider::kUdpMulticast: ParseMulticast(network, url); break;
    case LcmProvider::kTcpQueue:
      ParseAddress(network.empty() ? "127.0.0.1:7700" : network, "tcpq://127.0.0.1:7700", url);
      break;
    case LcmProvider::kFile: ParseFile(network, direction, url); break;
    case LcmProvider::kMemory: break;
  }
  return url;
}

std::string TcpqComplaint(const LcmUrl& url, const std::string& why) {
  return Complaint(url, "no LCM TCP server answers there (" + why + ")",
                   "start one at " + url.address + " port " + std::to_string(url.port));
}

std::string ProbeLcmUrl(const LcmUrl& url) {
  switch (url.provider) {
    case LcmProvider::kUdpMulticast: return ProbeMulticast(url);
    case LcmProvider::kTcpQueue: return ProbeTcp(url);
    case LcmProvider::kFile: return ProbeFile(url);
    case LcmProvider::kMemory: return {};
  }
  return {};
}

}  // namespace chequer
