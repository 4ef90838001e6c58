#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "core/clock.h"
#include "core/printable.h"
#include "publish/channels.h"
#include "publish/lcm_subscriber.h"
#include "tools/columns.h"
#include "tools/commands.h"
#include "tools/id_filter.h"
#include "tools/live_arena.h"
#include "tools/live_robots.h"
#include "tools/live_table.h"
#include "tools/message_text.h"
#include "tools/number_check.h"
#include "tools/robot_text.h"
#include "tools/setup_option.h"
#include "tools/truth_check.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;

/// How often the live table is drawn anew.
constexpr milliseconds kRedraw{100};

struct ListenRequest {
  std::string config;
  std::string url;  ///< empty: the configuration's, or the default
  ChannelFilter filter;
  bool json = false;
  bool arena = false;       ///< a map instead of tables
  std::uint64_t count = 0;  ///< frames; 0: no limit
  double seconds = 0;       ///< 0: no limit
  std::string truth;        ///< a recording; empty: none
  std::string ids;          ///< such as 0-9,17; empty: all
};

enum class Form { kTable, kPlain, kJson };

int TerminalLines() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row >= 4 ? size.ws_row - 1 : 24;
}

int TerminalColumns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col >= 20 ? size.ws_col : 80;
}

/// Prints what arrives and knows when it is enough.
class Listener {
 public:
  explicit Listener(const ListenRequest& request)
      : request_(request),
        form_(request.json                 ? Form::kJson
              : isatty(STDOUT_FILENO) != 0 ? Form::kTable
                                           : Form::kPlain),
        ids_(request.ids) {
    if (!request.ids.empty() && !request.truth.empty())
      throw CLI::ValidationError("--ids", "hides markers that --truth would miss; give one of them");
    if (request.arena && form_ != Form::kTable)
      throw CLI::ValidationError("--arena", "draws on a terminal; standard output is none, or --json was given");
    if (!request.truth.empty()) truth_.emplace(request.truth);
  }

  void Run() {
    LcmSubscriber subscriber(request_.url, request_.filter,
                             [this](const std::string& channel, ReceivedMessage&& message) {
                               if (!request_.ids.empty()) ids_.Keep(message);
                               std::visit([&](const auto& received) { Take(channel, received); }, message);
                             });
    std::fprintf(stderr, "listening at %s\n", request_.url.c_str());
    const MonotonicTime begin = clock_.monotonic();
    while (!IsEnough(clock_.monotonic() - begin)) {
      if (subscriber.Wait(kRedraw) == LcmSubscriber::Outcome::kClosed) break;
      if (form_ == Form::kTable) Redraw();
      if (std::ferror(stdout) != 0) throw std::runtime_error("standard output cannot be written");
    }
    if (subscriber.unreadable() > 0)
      std::fprintf(stderr, "chequer listen: %llu messages were of another version or damaged\n",
                   static_cast<unsigned long long>(subscriber.unreadable()));
    Conclude();
  }

 private:
  bool IsEnough(std::chrono::microseconds listened) const {
    return ended_ || (request_.count > 0 && frames_ >= request_.count) ||
           (request_.seconds > 0 && listened > std::chrono::duration<double>(request_.seconds));
  }

  void Take(const std::string& channel, const PosesMessage& message) {
    // Where a daemon publishes its frames twice, they are counted and shown once unless they were asked for by name.
    if (channel.ends_with(kCameraSuffix) && channel != request_.filter.channel && form_ != Form::kJson) {
      CompareWithTruth(message);
      return;
    }
    // One call to the subscriber is one message, but a slow terminal must not make more of them than was asked for.
    if (!channel.ends_with(kCameraSuffix) || channel == request_.filter.channel) ++frames_;
    CompareWithTruth(message);
    if (request_.arena) arena_.Add(channel, message, clock_.monotonic());
    if (form_ == Form::kTable)
      table_.Add(channel, message, clock_.monotonic());
    else
      PrintLine(form_ == Form::kJson ? JsonLine(channel, message) : PlainLine(message));
  }

  void Take(const std::string& channel, const StatusMessage& message) {
    if (truth_ && message.camera_state == CameraState::kEnded) ended_ = true;
    if (form_ != Form::kTable) PrintLine(form_ == Form::kJson ? JsonLine(channel, message) : PlainLine(message));
  }

  template <typename Message>
  void TakeRobots(const std::string& channel, const Message& message) {
    if (channel == request_.filter.channel) ++frames_;  // they come once a frame, and no poses come
    if (request_.arena) arena_.Add(channel, message, clock_.monotonic());
    if (form_ == Form::kTable)
      robots_.Add(channel, message, clock_.monotonic());
    else
      PrintLine(form_ == Form::kJson ? JsonLine(channel, message) : PlainLine(message));
  }
  void Take(const std::string& channel, const RobotsMessage& message) { TakeRobots(channel, message); }
  void Take(const std::string& channel, const TracksMessage& message) { TakeRobots(channel, message); }

  /// The truth of a recording is what its camera sees.
  void CompareWithTruth(const PosesMessage& message) {
    if (!truth_) return;
    if (message.frame == "camera")
      truth_->Add(message);
    else
      other_frame_ = message.frame;
  }

  /// Flushed at once: whoever reads wants it live.
  static void PrintLine(const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  }

  void Redraw() {
    const MonotonicTime now = clock_.monotonic();
    if (now < next_redraw_) return;
    next_redraw_ = now + kRedraw;
    // To the top left, then over the last table: the rest of each line and what is left below it away.
    std::string text = "\x1b[H";
    for (const char c : CutLines(Tables(now), TerminalColumns()))
      text.append(c == '\n' ? "\x1b[K\n" : std::string(1, c));
    std::printf("%s\x1b[J", text.c_str());
    std::fflush(stdout);
  }

  /// Markers, and below them robots where there are any; or the map.
  std::string Tables(MonotonicTime now) {
    const int lines = TerminalLines();
    if (request_.arena) return arena_.Text(now, std::max(5, lines), TerminalColumns());
    const std::string robots = robots_.Text(now, std::max(3, lines / 2));
    return table_.Text(now, std::max(3, lines - static_cast<int>(std::count(robots.begin(), robots.end(), '\n')))) +
           robots;
  }

  void Conclude() const {
    if (truth_) {
      PrintLine(truth_->Summary());
      if (!other_frame_.empty() && !truth_->Passed())
        std::fprintf(stderr,
                     "chequer listen: poses came in the frame '%s'; --truth compares in the camera's: set frames = "
                     "\"both\" in [world] of chequerd's configuration\n",
                     Printable(other_frame_).c_str());
      if (!truth_->Passed()) throw CLI::RuntimeError(kExitInput);
    }
    if (request_.count > 0 && frames_ < request_.count)
      throw std::runtime_error("only " + std::to_string(frames_) + " of " + std::to_string(request_.count) +
                               " frames came from " + request_.url);
  }

  const ListenRequest& request_;
  Form form_;
  IdFilter ids_;
  Clock clock_ = Clock::System();
  LiveTable table_;
  LiveArena arena_;
  LiveRobots robots_;
  std::optional<TruthCheck> truth_;
  std::string other_frame_;  ///< in which poses came that the truth cannot be compared with
  std::uint64_t frames_ = 0;
  bool ended_ = false;
  MonotonicTime next_redraw_{};
};

/// What was not typed; messages of one camera where a configuration names one.
void TakeSetup(ListenRequest& request) {
  const auto setup = LoadSetup(request.config);
  if (request.url.empty()) request.url = setup ? ListenUrlIn(*setup) : DefaultListenUrl();
  if (setup && request.filter.prefix.empty() && request.filter.channel.empty())
    request.filter.prefix = PrefixIn(*setup);
}

}  // namespace

void AddListenCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("listen", "Shows the poses and tracks that arrive over LCM");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<ListenRequest>();
  AddSetupOption(*command, request->config, "the LCM URL and the channels' prefix");
  AddListenUrlOption(*command, request->url);
  command->add_option("--prefix", request->filter.prefix, "Only the channels PREFIX_POSES, PREFIX_TRACKS and so on");
  command->add_option("--channel", request->filter.channel, "Only this channel");
  command->add_option("--ids", request->ids, "Only markers of these ids, and robots that bear them, such as 0-9,17")
      ->type_name("LIST");
  command->add_flag("--json", request->json, "One JSON object a line and message instead of a table");
  command->add_flag("--arena", request->arena, "A map of robots (or markers) on the whole terminal instead of a table");
  command->add_option("--count", request->count, "End after so many frames; status 1 if fewer came")
      ->check(IsAboveZero)
      ->check(IsWhole());
  command->add_option("--seconds", request->seconds, "End after so many seconds")->check(IsAboveZero);
  command
      ->add_option("--truth", request->truth,
                   "Recording that chequerd replays: compare with its truth until it is over; status 1 if wrong")
      ->type_name("FOLDER");
  command->footer(
      "On a terminal a table of what is seen now, otherwise a line a message. Positions are metres in the frame of "
      "the\n"
      "camera (x right, y down, z forward), or in the world where chequerd knows it; the heading is the direction of\n"
      "the marker's x axis in its x-y plane, degrees from x towards y; the age is the time since the capture. Robots\n"
      "and tracks are shown below the markers, with speed and yaw rate.\n\n"
      "Of the camera of a configuration; ten frames of the camera named ceiling, as JSON:\n"
      "  chequer listen --config north\n"
      "  chequer listen --prefix CHEQUER_ceiling --json --count 10");
  command->callback([request] {
    if (const std::string wrong = request->filter.Check(); !wrong.empty())
      throw CLI::ValidationError("--prefix, --channel", wrong);
    TakeSetup(*request);
    Listener(*request).Run();
  });
}

}  // namespace chequer
