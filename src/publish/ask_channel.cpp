#include "publish/ask_channel.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "publish/channels.h"
#include "publish/lcm_datagram.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

/// An ask_t has 73 bytes; LCM's header and the longest channel come to 72.
constexpr std::size_t kLongestRequest = 256;
/// Some dozen requests: more askers than are heeded.
constexpr int kRequestBuffer = 16384;

UniqueFd SocketFor(const LcmUrl& url, bool loopback) {
  UniqueFd result(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const auto found = url.arguments.find("ttl");
  const unsigned char ttl =
      loopback || found == url.arguments.end() ? 0 : static_cast<unsigned char>(std::stoi(found->second));
  ::setsockopt(result.get(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  in_addr interface {};
  interface.s_addr = htonl(INADDR_LOOPBACK);
  if (loopback) ::setsockopt(result.get(), IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
  return result;
}

void AppendWord(std::uint32_t word, std::vector<std::uint8_t>& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
}

}  // namespace

AskListener::AskListener(const LcmUrl& url, const std::string& prefix)
    : listener_(url, ChannelName(prefix, kAskSuffix),
                {.from = url.LeavesTheHost() ? HeardFrom::kDefaultRouteAndHost : HeardFrom::kThisHost,
                 .max_datagram = kLongestRequest,
                 .receive_buffer = kRequestBuffer}) {}

std::optional<AskMessage> AskListener::Next() {
  while (const auto heard = listener_.Next()) {
    auto message = DecodeViewMessage(heard->message);
    if (message && std::holds_alternative<AskMessage>(*message)) return std::get<AskMessage>(std::move(*message));
  }
  return std::nullopt;
}

AskSender::AskSender(const LcmUrl& url) : url_(url) {
  if (url.provider != LcmProvider::kUdpMulticast) return;
  over_loopback_ = SocketFor(url, true);
  by_route_ = SocketFor(url, false);
}

bool AskSender::Send(const std::string& prefix, const AskMessage& message) {
  if (!over_loopback_.valid()) return false;
  std::vector<std::uint8_t> datagram;
  AppendWord(kShortLcmMessage, datagram);
  AppendWord(number_++, datagram);
  const std::string channel = ChannelName(prefix, kAskSuffix);
  datagram.insert(datagram.end(), channel.c_str(), channel.c_str() + channel.size() + 1);
  const std::vector<std::uint8_t> encoded = EncodeView(message);
  datagram.insert(datagram.end(), encoded.begin(), encoded.end());
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url_.port);
  ::inet_pton(AF_INET, url_.address.c_str(), &address.sin_addr);
  bool sent = false;
  for (const UniqueFd* way : {&over_loopback_, &by_route_})
    sent = ::sendto(way->get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                    sizeof address) == static_cast<ssize_t>(datagram.size()) ||
           sent;
  return sent;
}

}  // namespace chequer
