#include "publish/status_listener.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>
#include <span>
#include <utility>
#include <variant>

#include "publish/wire.h"

namespace chequer {
namespace {

/// The first word of a message that fits into one datagram, which a status does.
constexpr std::uint32_t kShortMessage = 0x4c433032;  // "LC02"
constexpr std::size_t kMessageHeaderBytes = 8;       // that word, and a number
constexpr std::size_t kMaxDatagram = 65536;
/// A filter sees the header of UDP in front of the datagram.
constexpr std::uint32_t kUdpHeaderBytes = 8;

/// A program for the kernel that passes datagrams alone whose channel is that one.
std::vector<sock_filter> FilterOf(const std::string& channel) {
  std::vector<sock_filter> program;
  const auto require = [&](std::uint16_t width, std::uint32_t offset, std::uint32_t value) {
    program.push_back(BPF_STMT(static_cast<std::uint16_t>(BPF_LD | width | BPF_ABS), kUdpHeaderBytes + offset));
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  };
  require(BPF_W, 0, kShortMessage);
  // With its zero byte, so that longer names do not pass.
  for (std::size_t i = 0; i <= channel.size(); ++i)
    require(BPF_B, static_cast<std::uint32_t>(kMessageHeaderBytes + i), static_cast<std::uint8_t>(channel.c_str()[i]));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, kMaxDatagram));
  return program;
}

template <typename Value>
bool Set(const UniqueFd& socket, int level, int option, const Value& value) {
  return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

}  // namespace

StatusListener::StatusListener(const LcmUrl& url, std::string channel)
    : url_(url), channel_(std::move(channel)), datagram_(kMaxDatagram) {
  Open();
}

void StatusListener::Open() {
  if (url_.provider != LcmProvider::kUdpMulticast) return;
  UniqueFd listener(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  std::vector<sock_filter> program = FilterOf(channel_);
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url_.port);
  ::inet_pton(AF_INET, url_.address.c_str(), &address.sin_addr);
  ip_mreq group{};
  group.imr_multiaddr = address.sin_addr;
  const bool is_open = listener.valid() && Set(listener, SOL_SOCKET, SO_ATTACH_FILTER, filter) &&
                       Set(listener, SOL_SOCKET, SO_REUSEADDR, 1) &&
                       ::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                       Set(listener, IPPROTO_IP, IP_ADD_MEMBERSHIP, group);
  if (is_open) socket_ = std::move(listener);
}

std::optional<StatusListener::Heard> StatusListener::Next() {
  if (!socket_.valid()) Open();
  while (socket_.valid()) {
    sockaddr_in from{};
    socklen_t from_bytes = sizeof from;
    const ssize_t bytes = ::recvfrom(socket_.get(), datagram_.data(), datagram_.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &from_bytes);
    if (bytes < 0) break;
    const std::size_t head = kMessageHeaderBytes + channel_.size() + 1;
    if (static_cast<std::size_t>(bytes) < head) continue;
    auto message = DecodeMessage(std::span(datagram_).first(static_cast<std::size_t>(bytes)).subspan(head));
    if (!message || !std::holds_alternative<StatusMessage>(*message)) continue;
    char text[INET_ADDRSTRLEN] = "";
    ::inet_ntop(AF_INET, &from.sin_addr, text, sizeof text);
    return Heard{std::get<StatusMessage>(std::move(*message)), text};
  }
  return std::nullopt;
}

}  // namespace chequer
