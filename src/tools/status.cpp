#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/clock.h"
#include "core/suggestion.h"
#include "publish/lcm_subscriber.h"
#include "tools/commands.h"
#include "tools/message_text.h"
#include "tools/number_check.h"
#include "tools/setup_option.h"
#include "tools/status_board.h"

namespace chequer {
namespace {

// Beside those of all commands, and as those of `systemctl status`.
constexpr int kExitUnwell = 3;
constexpr int kExitNotHeard = 4;

struct StatusRequest {
  std::string config;
  std::string name;  ///< of a camera; empty: all
  std::string url;
  double seconds = 2.5;  ///< two statuses, and some slack
  bool json = false;
};

void PrintBoard(const StatusBoard& board, bool json, MonotonicTime now) {
  if (!json) {
    std::fputs(board.Text(now).c_str(), stdout);
  } else {
    for (const StatusBoard::Row& row : board.Rows(now))
      std::printf("%s\n", JsonLine(row.key.channel, row.entry.status).c_str());
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output cannot be written");
}

/// What was heard instead, and which of it was probably meant.
std::string OthersText(const std::string& name, const std::vector<std::string>& others) {
  if (name.empty()) return "; is chequerd running, and is there a multicast route? chequerd(8) tells how to look";
  if (others.empty()) return ", nor any other";
  std::string heard;
  for (const std::string& other : others) heard += (heard.empty() ? "" : ", ") + other;
  const std::string nearest = DidYouMean(name, others);
  return nearest.empty() ? "; heard were " + heard : nearest + " Heard were " + heard;
}

void ShowStatus(const StatusRequest& request) {
  const Clock clock = Clock::System();
  StatusBoard board(request.name);
  LcmSubscriber subscriber(request.url, {}, [&](const std::string& channel, ReceivedMessage&& message) {
    if (const auto* status = std::get_if<StatusMessage>(&message)) board.Add(channel, *status, clock.monotonic());
  });
  const MonotonicTime end = clock.monotonic() + std::chrono::duration_cast<std::chrono::microseconds>(
                                                    std::chrono::duration<double>(request.seconds));
  while (request.name.empty() || board.IsEmpty()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - clock.monotonic());
    if (left.count() <= 0 || subscriber.Wait(left) == LcmSubscriber::Outcome::kClosed) break;
  }
  if (board.IsEmpty()) {
    std::fprintf(stderr, "chequer status: %s was heard at %s within %g s%s\n",
                 request.name.empty() ? "no camera" : ("no camera named " + request.name).c_str(), request.url.c_str(),
                 request.seconds, OthersText(request.name, board.OthersHeard()).c_str());
    throw CLI::RuntimeError(kExitNotHeard);
  }
  const MonotonicTime now = clock.monotonic();
  PrintBoard(board, request.json, now);
  if (!board.AllWell(now)) throw CLI::RuntimeError(kExitUnwell);
}

}  // namespace

void AddStatusCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("status", "Shows how the cameras' services fare");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<StatusRequest>();
  command->add_option("name", request->name, "Only the camera of that name")->type_name("NAME");
  AddSetupOption(*command, request->config, "the camera's name and the LCM URL");
  AddListenUrlOption(*command, request->url);
  command->add_option("--seconds", request->seconds, "Listen for so long; each service tells of itself once a second")
      ->check(IsWithin(0.01, 86400))
      ->capture_default_str();
  command->add_flag("--json", request->json, "One JSON object a line and camera instead of a table");
  command->footer(
      "Every camera that is heard on the network: its state, frames published a second, markers a frame, latency from\n"
      "capture to publishing (median and 99th percentile), frames dropped since it started, version, and the time\n"
      "since it was heard; then what is wrong with it, and warnings about the quality of what it sees.\n\n"
      "Exit status: 0 where all do what they are for, 3 where one does not or several publish as one camera, 4 where\n"
      "none was heard, 1 where LCM cannot be opened.\n\n"
      "In a script:\n"
      "  chequer status north >/dev/null || echo 'look after the camera north'");
  command->callback([request] {
    const auto setup = LoadSetup(request->config);
    if (request->url.empty()) request->url = setup ? ListenUrlIn(*setup) : DefaultListenUrl();
    if (setup && request->name.empty()) request->name = CameraNameIn(*setup);
    ShowStatus(*request);
  });
}

}  // namespace chequer
