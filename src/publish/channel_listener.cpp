#include "publish/channel_listener.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <utility>

#include "publish/lcm_datagram.h"

namespace chequer {
namespace {

/// A filter sees the header of UDP in front of the datagram.
constexpr std::uint32_t kUdpHeaderBytes = 8;

/// A program for the kernel that passes datagrams alone whose channel is that one, and which are not too long.
std::vector<sock_filter> FilterOf(const std::string& channel, std::size_t max_datagram) {
  const auto most = static_cast<std::uint32_t>(max_datagram);
  std::vector<sock_filter> program;
  program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, most + kUdpHeaderBytes, 0, 1));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  const auto require = [&](std::uint16_t width, std::uint32_t offset, std::uint32_t value) {
    program.push_back(BPF_STMT(static_cast<std::uint16_t>(BPF_LD | width | BPF_ABS), kUdpHeaderBytes + offset));
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  };
  require(BPF_W, 0, kShortLcmMessage);
  // With its zero byte, so that longer names do not pass.
  for (std::size_t i = 0; i <= channel.size(); ++i)
    require(BPF_B, static_cast<std::uint32_t>(kLcmHeaderBytes + i), static_cast<std::uint8_t>(channel.c_str()[i]));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, most + kUdpHeaderBytes));
  return program;
}

template <typename Value>
bool Set(const UniqueFd& socket, int level, int option, const Value& value) {
  return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

bool Join(const UniqueFd& socket, in_addr group, in_addr_t interface) {
  ip_mreq request{};
  request.imr_multiaddr = group;
  request.imr_interface.s_addr = htonl(interface);
  return Set(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, request);
}

/// Joins the group where it is to be heard. The loopback interface needs no route for that.
bool JoinWhereHeard(const UniqueFd& socket, in_addr group, HeardFrom from) {
  // Else the kernel passes what came over any interface on which another program joined the group.
  if (!Set(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0)) return false;
  bool joined = false;
  if (from != HeardFrom::kThisHost) joined = Join(socket, group, INADDR_ANY);
  if (from != HeardFrom::kDefaultRoute) joined = Join(socket, group, INADDR_LOOPBACK) || joined;
  return joined;
}

}  // namespace

ChannelListener::ChannelListener(const LcmUrl& url, std::string channel, ChannelListenerOptions options)
    : url_(url), channel_(std::move(channel)), options_(options), datagram_(options.max_datagram) {
  Open();
}

void ChannelListener::Open() {
  if (url_.provider != LcmProvider::kUdpMulticast) return;
  UniqueFd listener(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  std::vector<sock_filter> program = FilterOf(channel_, options_.max_datagram);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url_.port);
  ::inet_pton(AF_INET, url_.address.c_str(), &address.sin_addr);
  const bool has_buffer = options_.receive_buffer == 0 || Set(listener, SOL_SOCKET, SO_RCVBUF, options_.receive_buffer);
  const bool is_open = listener.valid() && has_buffer && Set(listener, SOL_SOCKET, SO_ATTACH_FILTER, filter) &&
                       Set(listener, SOL_SOCKET, SO_REUSEADDR, 1) &&
                       ::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                       JoinWhereHeard(listener, address.sin_addr, options_.from);
  if (is_open) socket_ = std::move(listener);
}

std::optional<ChannelListener::Heard> ChannelListener::Next() {
  if (!socket_.valid()) Open();
  while (socket_.valid()) {
    sockaddr_in from{};
    socklen_t from_bytes = sizeof from;
    const ssize_t bytes = ::recvfrom(socket_.get(), datagram_.data(), datagram_.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &from_bytes);
    if (bytes < 0) break;
    const std::size_t head = kLcmHeaderBytes + channel_.size() + 1;
    if (static_cast<std::size_t>(bytes) < head) continue;
    char text[INET_ADDRSTRLEN] = "";
    ::inet_ntop(AF_INET, &from.sin_addr, text, sizeof text);
    return Heard{std::span(datagram_).first(static_cast<std::size_t>(bytes)).subspan(head), text};
  }
  return std::nullopt;
}

}  // namespace chequer
