#include "capture/recording_text.h"

#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace chequer {
namespace {

constexpr std::array<std::pair<std::string_view, YuvRange>, 2> kYuvRanges{
    {{"full", YuvRange::kFull}, {"limited", YuvRange::kLimited}}};

void ReadFileName(TomlTable& table, std::string_view key, std::string& name) {
  if (!table.Read(key, name)) return;
  const std::string wrong = CheckFileName(name);
  if (!wrong.empty()) table.Fail(key, wrong);
}

/// As a TOML basic string.
std::string Quoted(std::string_view text) {
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      constexpr std::string_view kHex = "0123456789abcdef";
      quoted.append("\\u00").append(1, kHex[static_cast<unsigned char>(c) >> 4]).append(1, kHex[c & 15]);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string Exact(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

/// One line of an index, and what to say of it.
class LineReader {
 public:
  LineReader(std::string_view line, const std::string& name, std::size_t number)
      : rest_(line), name_(name), number_(number) {}

  std::string_view Field() {
    if (!rest_) Fail("must have the 4 fields " + std::string(kFrameIndexHeader));
    const std::size_t comma = rest_->find(',');
    const std::string_view field = rest_->substr(0, comma);
    if (comma == std::string_view::npos)
      rest_.reset();
    else
      rest_->remove_prefix(comma + 1);
    return field;
  }

  template <typename Integer>
  Integer Number(std::string_view field_name, Integer min, std::string_view limit, Integer max) {
    const std::string_view field = Field();
    Integer value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size() || value < min || value > max)
      Fail(std::string(field_name) + " = " + std::string(field.substr(0, 40)) + ": must be a whole number from " +
           std::to_string(min) + std::string(limit) + " to " + std::to_string(max));
    return value;
  }

  void End() const {
    if (rest_) Fail("must have the 4 fields " + std::string(kFrameIndexHeader));
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw std::runtime_error(name_ + ":" + std::to_string(number_) + ": " + what);
  }

 private:
  std::optional<std::string_view> rest_;
  const std::string& name_;
  std::size_t number_;
};

RecordedFrame ParseFrameLine(std::string_view line, const std::string& name, std::size_t number,
                             const RecordedFrame* before) {
  constexpr std::int64_t kMaxTime = std::numeric_limits<std::int64_t>::max() / 4;  // sums of two stay representable
  constexpr std::uint64_t kMaxSequence = std::numeric_limits<std::uint64_t>::max() / 4;
  const std::string_view limit = before == nullptr ? "" : " (one more than in the line before)";
  LineReader reader(line, name, number);
  RecordedFrame frame;
  frame.file = reader.Field();
  if (const std::string wrong = CheckFileName(frame.file); !wrong.empty()) reader.Fail("file: " + wrong);
  frame.captured_utc = UtcTime(std::chrono::microseconds(reader.Number<std::int64_t>("utc_us", 0, "", kMaxTime)));
  const std::int64_t first_time = before == nullptr ? 0 : before->captured_monotonic.time_since_epoch().count() + 1;
  frame.captured_monotonic = MonotonicTime(
      std::chrono::microseconds(reader.Number<std::int64_t>("monotonic_us", first_time, limit, kMaxTime)));
  const std::uint64_t first_sequence = before == nullptr ? 0 : before->sequence + 1;
  frame.sequence = reader.Number<std::uint64_t>("sequence", first_sequence, limit, kMaxSequence);
  reader.End();
  return frame;
}

}  // namespace

RecordingInfo ParseRecordingInfo(TomlFile file) {
  RecordingInfo info;
  TomlTable table = file.root().Table("recording");
  table.Read("camera", info.camera, LengthRange{1, 100});
  table.Require("width", info.width, IntegerRange{1, kMaxImageSide});
  table.Require("height", info.height, IntegerRange{1, kMaxImageSide});
  std::string format;
  table.Require("pixel_format", format);
  const auto known = ParsePixelFormat(format);
  if (!known) table.Fail("pixel_format", "must be one of " + PixelFormatNames());
  info.pixel_format = *known;
  if (!SizeIsValid(info.pixel_format, info.width, info.height))
    table.Fail("pixel_format", "needs an even width, NV12 an even height too; here it is " +
                                   std::to_string(info.width) + " x " + std::to_string(info.height));
  double gamma = 0;
  if (table.Read("gamma", gamma, NumberRange{0.2, 5})) info.tone_curve = ToneCurve::Gamma(gamma);
  table.Read("yuv_range", info.yuv_range, kYuvRanges);
  table.Require("fps", info.fps, NumberRange{0.001, 10000});
  ReadFileName(table, "calibration", info.calibration);
  ReadFileName(table, "truth", info.truth);
  file.CheckAllKeysRead();
  return info;
}

std::string FormatRecordingInfo(const RecordingInfo& info) {
  std::string text = "[recording]\n";
  text += "camera = " + Quoted(info.camera) + "\n";
  text += "width = " + std::to_string(info.width) + "\n";
  text += "height = " + std::to_string(info.height) + "\n";
  text += "pixel_format = " + Quoted(PixelFormatName(info.pixel_format)) + "\n";
  if (!info.tone_curve.is_srgb()) text += "gamma = " + Exact(info.tone_curve.gamma()) + " # 1 is linear\n";
  if (IsYuv(info.pixel_format))
    text += std::string("yuv_range = ") + (info.yuv_range == YuvRange::kFull ? "\"full\"" : "\"limited\"") + "\n";
  text += "fps = " + Exact(info.fps) + "\n";
  if (!info.calibration.empty()) text += "calibration = " + Quoted(info.calibration) + "\n";
  if (!info.truth.empty()) text += "truth = " + Quoted(info.truth) + "\n";
  return text;
}

std::vector<RecordedFrame> ParseFrameIndex(std::string_view text, const std::string& name) {
  std::vector<RecordedFrame> frames;
  for (std::size_t number = 1;; ++number) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return frames;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);  // edited elsewhere
    if (number == 1) {
      if (line != kFrameIndexHeader)
        throw std::runtime_error(name + ":1: must be the line " + std::string(kFrameIndexHeader));
      continue;
    }
    if (frames.size() == kMaxRecordedFrames)
      throw std::runtime_error(name + ":" + std::to_string(number) + ": more than the " +
                               std::to_string(kMaxRecordedFrames) + " frames a recording can have");
    frames.push_back(ParseFrameLine(line, name, number, frames.empty() ? nullptr : &frames.back()));
  }
}

std::string FormatFrameLine(const RecordedFrame& frame) {
  return frame.file + "," + std::to_string(frame.captured_utc.time_since_epoch().count()) + "," +
         std::to_string(frame.captured_monotonic.time_since_epoch().count()) + "," + std::to_string(frame.sequence) +
         "\n";
}

std::string CheckFileName(std::string_view name) {
  constexpr const char* kWanted = "must be the name of a file in the recording's folder";
  if (name.empty() || name.size() > 1000) return kWanted;
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == ',' || c == '"')
      return std::string(kWanted) + ", without commas, quotes and control characters";
  while (true) {
    const std::size_t slash = name.find('/');
    const std::string_view part = name.substr(0, slash);
    if (part.empty() || part == "." || part == "..") return std::string(kWanted) + ", without \"..\" or a leading /";
    if (slash == std::string_view::npos) return {};
    name.remove_prefix(slash + 1);
  }
}

}  // namespace chequer
