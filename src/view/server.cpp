#include "view/server.h"

#include <libwebsockets.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <list>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/clock.h"
#include "publish/instance.h"
#include "publish/lcm_subscriber.h"
#include "publish/lcm_url.h"
#include "view/assets.h"
#include "view/client_message.h"
#include "view/feed.h"
#include "view/http_rules.h"
#include "view/log_index.h"
#include "view/page_json.h"
#include "view/request_sender.h"
#include "view/view_client.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;

static_assert(Packet::kHeadroom >= LWS_PRE);

constexpr unsigned kMostConnections = 200;
constexpr std::size_t kMostPages = 64;
/// Each has a feed of its own, with the frames it keeps.
constexpr std::size_t kMostReplays = 8;
constexpr unsigned kHeaderBytes = 4096;
/// A request's headers must be there by then.
constexpr unsigned kHeaderSeconds = 5;
constexpr int kSendBufferBytes = 64 << 10;
/// More than a page's messages have.
constexpr std::size_t kPageReceiveBytes = 256;
constexpr std::size_t kChunkBytes = 16384;
constexpr int kMessagesAtOnce = 400;
constexpr milliseconds kTick{40}, kLcmRetry{1000}, kStateEvery{250};

/// What hangs on one connection; made and freed by libwebsockets, zeroed.
struct Connection {
  ViewClient* client;        ///< of a WebSocket
  const Assets::File* file;  ///< that is being sent
  std::size_t sent;
  char host[256];  ///< copied before the upgrade, which frees the headers
};

std::string HeaderOf(lws* wsi, lws_token_indexes token) {
  const int length = lws_hdr_total_length(wsi, token);
  if (length <= 0 || length >= static_cast<int>(kHeaderBytes)) return {};
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  const int copied = lws_hdr_copy(wsi, text.data(), length + 1, token);
  text.resize(static_cast<std::size_t>(std::max(0, copied)));
  return text;
}

}  // namespace

struct ViewServer::Impl {
  ViewServerOptions options;
  Clock clock = Clock::System();
  Assets assets;
  HttpRules rules;
  std::int64_t asker = static_cast<std::int64_t>(InstanceOfProcess() << 1);
  Feed feed{asker};
  std::shared_ptr<const LogIndex> log;
  std::optional<LcmSubscriber> subscriber;
  std::optional<RequestSender> requests;
  std::string trouble;
  MonotonicTime next_try{}, next_state{};
  Topic server_topic;
  std::uint64_t list_told = 0;

  struct Page {
    ViewClient client;
    lws* wsi;
    Topic state;  ///< of its own replay
    MonotonicTime state_at{};
  };
  std::list<Page> pages;

  lws_context* context = nullptr;
  lws_vhost* vhost = nullptr;
  std::array<lws_protocols, 4> protocols{};
  std::atomic<bool> stopping{false};

  explicit Impl(const ViewServerOptions& given)
      : options(given), assets(Assets::Load(given.page, given.chart)), rules(given.names) {
    if (!options.log.empty()) log = std::make_shared<LogIndex>(options.log);
    OpenContext();
    if (!log) OpenLcm();
  }

  ~Impl() {
    if (context != nullptr) lws_context_destroy(context);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  static int OnEvent(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t length) {
    auto* self = static_cast<Impl*>(lws_context_user(lws_get_context(wsi)));
    try {
      return self->Handle(wsi, reason, static_cast<Connection*>(user), in, length);
    } catch (const std::exception& error) {
      spdlog::error("a connection is closed: {}", error.what());
      return -1;
    }
  }

  void OpenContext() {
    lws_set_log_level(0, nullptr);
    protocols[0] = {"http", &OnEvent, sizeof(Connection), kHeaderBytes, 0, nullptr, kChunkBytes};
    // Without the last number libwebsockets hands the system pieces of the size of its receive buffer.
    protocols[1] = {"chequer", &OnEvent, sizeof(Connection), kPageReceiveBytes, 0, nullptr, kSendBufferBytes};
    protocols[2] = {"lcm", &OnEvent, 0, 0, 0, nullptr, 0};
    lws_context_creation_info info{};
    info.port = options.port;
    info.iface = options.address.c_str();
    info.protocols = protocols.data();
    info.user = this;
    info.gid = info.uid = static_cast<decltype(info.uid)>(-1);
    info.fd_limit_per_thread = kMostConnections;
    info.max_http_header_data2 = kHeaderBytes;
    info.max_http_header_pool2 = 32;
    info.timeout_secs = kHeaderSeconds;
    info.keepalive_timeout = static_cast<int>(kHeaderSeconds);
    info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_DISABLE_IPV6;
    context = lws_create_context(&info);
    if (context == nullptr) throw std::runtime_error("the web server could not be set up");
    vhost = lws_create_vhost(context, &info);
    if (vhost == nullptr)
      throw std::runtime_error("port " + std::to_string(options.port) + " of " + options.address +
                               " cannot be listened at: another program has it, or the address is not this host's; "
                               "--port gives another");
  }

  void OpenLcm() {
    next_try = clock.monotonic() + kLcmRetry;
    try {
      subscriber.emplace(LcmSubscriber::OfBytes(
          options.url, {"", "", true},
          [this](const std::string& channel, std::span<const std::uint8_t> bytes) { feed.Take(channel, bytes); }));
      requests.emplace(ParseLcmUrl(options.url, LcmDirection::kSubscribe), asker);
      trouble.clear();
      lws_sock_file_fd_type fd{};
      fd.filefd = dup(subscriber->fd());  // it is closed with its connection, LCM's own is LCM's
      if (lws_adopt_descriptor_vhost(vhost, LWS_ADOPT_RAW_FILE_DESC, fd, "lcm", nullptr) == nullptr)
        throw std::runtime_error("LCM's messages cannot be waited for");
      spdlog::info("listening at {}", options.url);
    } catch (const std::runtime_error& error) {
      if (trouble != error.what()) spdlog::error("{}", error.what());
      trouble = error.what();
      subscriber.reset();
    }
    ++list_told;  // said anew
    TellState();
  }

  // ---- connections

  int Handle(lws* wsi, lws_callback_reasons reason, Connection* connection, void* in, std::size_t length) {
    switch (reason) {
      case LWS_CALLBACK_HTTP: return Serve(wsi, *connection, {static_cast<const char*>(in), length});
      case LWS_CALLBACK_HTTP_WRITEABLE: return SendFile(wsi, *connection);
      case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE: return 0;
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return MayConnect(wsi) ? 0 : 1;
      case LWS_CALLBACK_ESTABLISHED: return Begin(wsi, *connection);
      case LWS_CALLBACK_RECEIVE: return Receive(wsi, *connection, {static_cast<const std::uint8_t*>(in), length});
      case LWS_CALLBACK_SERVER_WRITEABLE: return SendNews(wsi, *connection);
      case LWS_CALLBACK_CLOSED:
        pages.remove_if([&](const Page& page) { return page.wsi == wsi; });
        NoteWatching();
        return 0;
      case LWS_CALLBACK_RAW_RX_FILE: return Listen();
      default: return 0;
    }
  }

  bool MayConnect(lws* wsi) {
    const std::string host = HeaderOf(wsi, WSI_TOKEN_HOST), origin = HeaderOf(wsi, WSI_TOKEN_ORIGIN);
    const std::size_t most = log ? kMostReplays : kMostPages;
    return rules.OriginIsOurs(origin, host) && pages.size() < most;
  }

  int Refuse(lws* wsi, unsigned status) {
    return lws_return_http_status(wsi, status, nullptr) != 0 ? -1 : lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
  }

  int Serve(lws* wsi, Connection& connection, std::string_view path) {
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return Refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    if (!rules.HostIsOurs(HeaderOf(wsi, WSI_TOKEN_HOST))) return Refuse(wsi, HTTP_STATUS_FORBIDDEN);
    connection.file = assets.Find(path);
    connection.sent = 0;
    if (connection.file == nullptr) return Refuse(wsi, HTTP_STATUS_NOT_FOUND);
    std::array<unsigned char, LWS_PRE + 2048> buffer;
    unsigned char* const begin = buffer.data() + LWS_PRE;
    unsigned char* at = begin;
    unsigned char* const end = buffer.data() + buffer.size() - 1;
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, connection.file->type.c_str(), connection.file->bytes.size(),
                                    &at, end) != 0)
      return -1;
    for (const HttpHeader& header : kSafetyHeaders)
      if (lws_add_http_header_by_name(wsi, reinterpret_cast<const unsigned char*>(header.name),
                                      reinterpret_cast<const unsigned char*>(header.value),
                                      static_cast<int>(std::strlen(header.value)), &at, end) != 0)
        return -1;
    if (lws_finalize_write_http_header(wsi, begin, &at, end) != 0) return -1;
    lws_callback_on_writable(wsi);
    return 0;
  }

  int SendFile(lws* wsi, Connection& connection) {
    if (connection.file == nullptr) return -1;
    const std::string& bytes = connection.file->bytes;
    const std::size_t count = std::min(kChunkBytes, bytes.size() - connection.sent);
    std::array<unsigned char, LWS_PRE + kChunkBytes> buffer;
    std::memcpy(buffer.data() + LWS_PRE, bytes.data() + connection.sent, count);
    connection.sent += count;
    const bool last = connection.sent == bytes.size();
    const int written = lws_write(wsi, buffer.data() + LWS_PRE, count, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP);
    if (written != static_cast<int>(count)) return -1;
    if (!last) {
      lws_callback_on_writable(wsi);
      return 0;
    }
    connection.file = nullptr;
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
  }

  int Begin(lws* wsi, Connection& connection) {
    std::unique_ptr<Replay> replay;
    if (log) replay = std::make_unique<Replay>(log, clock.monotonic());
    pages.push_back({ViewClient(std::move(replay)), wsi, {}, {}});
    connection.client = &pages.back().client;
    // What waits in the system for a slow page is stale when it comes: little may.
    setsockopt(lws_get_socket_fd(wsi), SOL_SOCKET, SO_SNDBUF, &kSendBufferBytes, sizeof kSendBufferBytes);
    lws_callback_on_writable(wsi);
    return 0;
  }

  int Receive(lws* wsi, Connection& connection, std::span<const std::uint8_t> bytes) {
    // A message of ours comes whole, in one piece; anything else is none.
    const bool whole = lws_is_first_fragment(wsi) != 0 && lws_is_final_fragment(wsi) != 0 &&
                       lws_frame_is_binary(wsi) != 0 && lws_remaining_packet_payload(wsi) == 0;
    const auto message = whole ? ParseClientMessage(bytes) : std::nullopt;
    if (!message || connection.client == nullptr) return -1;
    if (const auto* wish = std::get_if<PageWish>(&*message)) connection.client->set_wish(*wish);
    Replay* replay = connection.client->replay();
    if (const auto* seek = std::get_if<PageSeek>(&*message); seek && replay) replay->Seek(*seek, clock.monotonic());
    NoteWatching();
    AskDaemons();
    lws_callback_on_writable(wsi);
    return 0;
  }

  Page* PageOf(lws* wsi) {
    const auto found = std::find_if(pages.begin(), pages.end(), [&](const Page& page) { return page.wsi == wsi; });
    return found == pages.end() ? nullptr : &*found;
  }

  int SendNews(lws* wsi, const Connection&) {
    Page* page = PageOf(wsi);
    if (page == nullptr) return -1;
    const Topic& state = log ? page->state : server_topic;
    const SharedPacket packet = page->client.Take(page->client.FeedOf(feed), state);
    if (!packet) return 0;
    // What the system does not take at once libwebsockets keeps, one message at most, and calls again when it is gone.
    const int written = lws_write(wsi, packet->data(), packet->size(), LWS_WRITE_BINARY);
    if (written < static_cast<int>(packet->size())) return -1;
    if (page->client.HasNews(page->client.FeedOf(feed), state)) lws_callback_on_writable(wsi);
    return 0;
  }

  // ---- LCM, time

  int Listen() {
    for (int i = 0; i < kMessagesAtOnce; ++i) {
      const auto outcome = subscriber ? subscriber->Wait(milliseconds(0)) : LcmSubscriber::Outcome::kClosed;
      if (outcome == LcmSubscriber::Outcome::kTimeout) break;
      if (outcome == LcmSubscriber::Outcome::kClosed) {
        subscriber.reset();
        trouble = "LCM at " + options.url + " was closed";
        return -1;
      }
    }
    TellPages();
    return 0;
  }

  void NoteWatching() {
    feed.set_watched(
        std::any_of(pages.begin(), pages.end(), [](const Page& page) { return page.client.wish().visible; }));
  }

  std::vector<PageWish> Wishes() const {
    std::vector<PageWish> wishes;
    for (const Page& page : pages) wishes.push_back(page.client.wish());
    return wishes;
  }

  void AskDaemons() {
    if (requests && feed.watched()) requests->Ask(feed, Wishes(), clock.monotonic());
  }

  ServerState StateOf(const Feed& shown) const {
    ServerState state;
    state.instance = InstanceOfProcess();
    state.version = options.version;
    state.lcm_url = log ? std::string() : options.url;
    state.trouble = trouble;
    state.unreadable = shown.unreadable();
    state.cameras = shown.CameraList();
    return state;
  }

  void TellState() {
    server_topic = {server_topic.version + 1, ServerPacket(StateOf(feed))};
    list_told = feed.list_version();
  }

  void TellPages() {
    if (feed.list_version() != list_told) TellState();
    for (Page& page : pages)
      if (page.client.HasNews(page.client.FeedOf(feed), log ? page.state : server_topic))
        lws_callback_on_writable(page.wsi);
  }

  void PlayLogs(MonotonicTime now) {
    for (Page& page : pages) {
      Replay& replay = *page.client.replay();
      if (page.client.wish().visible) replay.Play(now);
      if (now < page.state_at) continue;
      page.state_at = now + kStateEvery;
      ServerState state = StateOf(replay.feed());
      state.replay = replay.State();
      page.state = {page.state.version + 1, ServerPacket(state)};
    }
  }

  void Tick() {
    const MonotonicTime now = clock.monotonic();
    if (!log && !subscriber && now >= next_try) OpenLcm();
    if (log) PlayLogs(now);
    AskDaemons();
    TellPages();
  }

  void Run() {
    // Events wake it; the tick is for what happens by itself.
    lws_sorted_usec_list_t timer{};
    struct Timer {
      lws_sorted_usec_list_t list;
      Impl* self;
    } tick{timer, this};
    const auto on_tick = [](lws_sorted_usec_list_t* list) {
      auto* each = reinterpret_cast<Timer*>(list);
      each->self->Tick();
      lws_sul_schedule(each->self->context, 0, &each->list, each->list.cb, std::chrono::microseconds(kTick).count());
    };
    lws_sul_schedule(context, 0, &tick.list, on_tick, 1);
    while (!stopping && lws_service(context, 0) >= 0) {
    }
    lws_sul_cancel(&tick.list);
  }
};

ViewServer::ViewServer(const ViewServerOptions& options) : impl_(std::make_unique<Impl>(options)) {}

ViewServer::~ViewServer() = default;

std::string ViewServer::url() const {
  return "http://" + impl_->options.address + ":" + std::to_string(lws_get_vhost_listen_port(impl_->vhost)) + "/";
}

void ViewServer::Run() { impl_->Run(); }

void ViewServer::Stop() {
  impl_->stopping = true;
  lws_cancel_service(impl_->context);
}

}  // namespace chequer
