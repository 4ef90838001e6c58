#include "tools/status_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "core/printable.h"
#include "publish/instance.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;

/// The daemon sends one a second; a third one missed is no accident.
constexpr seconds kStale{3};
/// Cameras of other names that are remembered, to be named where the wanted one is not heard.
constexpr std::size_t kMostOthers = 100;

std::string State(CameraState state) {
  switch (state) {
    case CameraState::kWaiting: return "waiting";
    case CameraState::kRunning: return "running";
    case CameraState::kEnded: return "ended";
  }
  return "unknown";  // of a newer version
}

double Milliseconds(microseconds time) { return static_cast<double>(time.count()) / 1000; }

std::string Latency(const StatusMessage& status) {
  const auto total = std::find_if(status.stages.begin(), status.stages.end(),
                                  [](const StageLatency& stage) { return stage.stage == "total"; });
  if (total == status.stages.end() || total->frames == 0) return "-";
  return fmt::format("{:.1f} ({:.1f})", Milliseconds(total->median), Milliseconds(total->p99));
}

using Line = std::vector<std::string>;

/// What the daemon's hints mean. lcmtypes/status_t.lcm lists them, too.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kHints{
    {{"black", "black: there is no light in the picture (is the cap on the lens, is the exposure long enough?)"},
     {"white", "white: nothing but full scale (the exposure is too long, or the gain too high)"},
     {"no_contrast", "no contrast: is the lens in focus, is something in front of it?"},
     {"blurred",
      "blurred: even the sharpest edges of the picture are wide (focus the lens; expose for a shorter time)"},
     {"no_board", "nothing that looks like a board is in view"},
     {"no_border",
      "patterns are in view, but none with the border of a marker that is sought: another size? `chequer "
      "explain` on a snapshot tries them all"},
     {"mirrored",
      "mirrored: boards have their inks the other way round (a mirrored print, or the camera's picture is "
      "flipped)"},
     {"outside_roster", "markers are in view whose ids the configuration's roster leaves out"}}};
constexpr std::string_view kLooksLike = "looks_like_";

std::string HintText(const NamedCount& count) {
  const std::string name = count.name.substr(kHintPrefix.size());
  for (const auto& [known, text] : kHints)
    if (name == known) return std::string(text);
  if (name.starts_with(kLooksLike)) {
    const std::string variant = name.substr(kLooksLike.size());
    return fmt::format(
        "these look like {}: {} different boards fit it far better than the variant that is sought; ids "
        "are wrong until variant = \"{}\"",
        variant, count.count, variant);
  }
  return "hint: " + name;  // of a newer daemon
}

std::string Aligned(const std::vector<Line>& lines) {
  std::string text;
  for (const Line& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      std::size_t width = 0;
      for (const Line& other : lines) width = std::max(width, other[i].size());
      const bool last = i + 1 == line.size();
      text += last ? line[i] : fmt::format("{:<{}}  ", line[i], width);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string Trouble(const StatusMessage& status, microseconds age) {
  if (age > kStale) return fmt::format("nothing has been heard for {:.0f} s", Milliseconds(age) / 1000);
  if (status.camera_state == CameraState::kEnded) return "the recording is over";
  if (status.camera_state == CameraState::kWaiting)
    return status.camera_message.empty() ? "waiting for the camera" : status.camera_message;
  if (!status.publisher.message.empty()) return status.publisher.message;
  if (!status.camera_message.empty()) return status.camera_message;
  if (status.publish_rate_hz <= 0) {
    const auto wrong_size = std::find_if(status.drops.begin(), status.drops.end(),
                                         [](const NamedCount& drop) { return drop.name == "wrong_size"; });
    if (wrong_size != status.drops.end() && wrong_size->count > 0)
      return fmt::format("wrong size: {} frames were not of the calibration's size, and none is published",
                         wrong_size->count);
    return "no frame is published";
  }
  return {};
}

std::vector<std::string> HintsOf(const StatusMessage& status) {
  std::vector<std::string> hints;
  std::uint64_t robots = 0, off_floor = 0;
  for (const NamedCount& count : status.detections) {
    if (count.name == "robots") robots = count.count;
    if (count.name == "off_floor") off_floor = count.count;
    if (count.count > 0 && count.name.starts_with(kHintPrefix)) hints.push_back(HintText(count));
  }
  if (off_floor > 0)
    hints.push_back(
        fmt::format("off the floor: {:.0f} % of the robots' poses{}",
                    100 * static_cast<double>(off_floor) / static_cast<double>(std::max(robots, off_floor)),
                    2 * off_floor > robots ? ": are the roster's heights, the side and the world right?" : ""));
  return hints;
}

std::string QualityRemark(const StatusMessage& status) {
  const double markers =
      status.markers_mean * status.publish_rate_hz * static_cast<double>(status.window.count()) / 1e6;
  std::string remark;
  for (const NamedCount& count : status.detections) {
    if (count.count == 0 || !count.name.starts_with(kWarningCountPrefix)) continue;
    remark += fmt::format("{}{} {:.0f} %", remark.empty() ? "" : ", ", count.name.substr(kWarningCountPrefix.size()),
                          100 * static_cast<double>(count.count) / std::max(markers, static_cast<double>(count.count)));
  }
  return remark;
}

void StatusBoard::Add(const std::string& channel, const StatusMessage& status, MonotonicTime now) {
  if (!name_.empty() && status.camera != name_) {
    if (others_.size() < kMostOthers) others_.insert(Printable(status.camera));
    return;
  }
  Entry& entry = entries_[{channel, InstanceOf(status).value_or(0)}];
  entry.first = entry.arrived == MonotonicTime{} ? now : entry.first;
  entry.status = status;
  entry.arrived = now;
}

std::vector<StatusBoard::Row> StatusBoard::Rows(MonotonicTime now) const {
  std::vector<Row> rows;
  std::map<std::string, MonotonicTime> last_begun;
  std::map<std::string, int> senders;
  entries_.ForEach([&](const Key& key, const Entry& entry) {
    MonotonicTime& begun = last_begun[key.channel];
    begun = std::max(begun, entry.first);
    return true;
  });
  entries_.ForEach([&](const Key& key, const Entry& entry) {
    if (entry.arrived < last_begun[key.channel]) return true;
    ++senders[key.channel];
    rows.push_back({key, entry, Trouble(entry.status, now - entry.arrived)});
    return true;
  });
  for (Row& row : rows)
    if (const int count = senders[row.key.channel]; count > 1)
      row.trouble = fmt::format("{} programs publish as {}: give each camera a name of its own ([camera] name)", count,
                                row.key.channel);
  return rows;
}

bool StatusBoard::AllWell(MonotonicTime now) const {
  const std::vector<Row> rows = Rows(now);
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.trouble.empty(); });
}

std::string StatusBoard::Text(MonotonicTime now) const {
  std::vector<Line> lines{
      {"camera", "state", "frames/s", "markers", "latency ms (99 %)", "dropped", "version", "age s"}};
  std::string remarks;
  for (const Row& row : Rows(now)) {
    const StatusMessage& status = row.entry.status;
    const std::string name = Printable(status.camera);
    lines.push_back({name, State(status.camera_state), fmt::format("{:.1f}", status.publish_rate_hz),
                     fmt::format("{:.1f}", status.markers_mean), Latency(status), std::to_string(status.frames_dropped),
                     Printable(status.version), fmt::format("{:.1f}", Milliseconds(now - row.entry.arrived) / 1000)});
    if (!row.trouble.empty()) remarks += name + ": " + Printable(row.trouble) + "\n";
    for (const std::string& hint : HintsOf(status)) remarks += name + ": " + Printable(hint) + "\n";
    if (const std::string quality = QualityRemark(status); !quality.empty())
      remarks += name + ": quality: " + Printable(quality) + " of the markers\n";
  }
  return Aligned(lines) + remarks;
}

}  // namespace chequer
