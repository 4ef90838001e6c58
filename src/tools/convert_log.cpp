#include "tools/convert_log.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <variant>

#include "core/file.h"
#include "core/output_file.h"
#include "publish/lcm_log.h"
#include "tools/message_text.h"
#include "tools/robot_text.h"

namespace chequer {
namespace {

/// The word before each event of a log.
constexpr std::array<unsigned char, 4> kSyncWord{0xed, 0xa1, 0xda, 0x01};

/// A file, or standard output where the name is "-".
class Output {
 public:
  explicit Output(const std::string& path) {
    if (path != "-") file_.emplace(path);
  }

  void Write(const std::string& text) {
    if (file_)
      file_->Write(text);
    else if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size())
      Fail();
  }
  /// Tells of a full disk, which shows only now. Without it an earlier file of that name stays as it was.
  void Finish() {
    if (file_)
      file_->Finish();
    else if (std::fflush(stdout) != 0)
      Fail();
  }

 private:
  [[noreturn]] static void Fail() {
    throw std::runtime_error(std::string("standard output: cannot be written: ") + std::strerror(errno));
  }

  std::optional<OutputFile> file_;
};

/// Whether a message belongs to the stream.
bool IsOf(const ReceivedMessage& message, LogStream stream) {
  switch (stream) {
    case LogStream::kAll: return true;
    case LogStream::kPoses: return std::holds_alternative<PosesMessage>(message);
    case LogStream::kRobots: return std::holds_alternative<RobotsMessage>(message);
    case LogStream::kTracks: return std::holds_alternative<TracksMessage>(message);
  }
  return false;
}

std::string CsvHeaderOf(LogStream stream) {
  if (stream == LogStream::kRobots) return RobotsCsvHeader();
  return stream == LogStream::kTracks ? TracksCsvHeader() : CsvHeader();
}

/// @param stream one that a table can hold.
std::string CsvText(const LogRecord& record, LogStream stream) {
  if (!IsOf(record.message, stream)) return {};
  if (stream == LogStream::kRobots) return CsvRows(record.channel, std::get<RobotsMessage>(record.message));
  if (stream == LogStream::kTracks) return CsvRows(record.channel, std::get<TracksMessage>(record.message));
  return CsvRows(record.channel, std::get<PosesMessage>(record.message));
}

std::string JsonText(const LogRecord& record) {
  return std::visit([&](const auto& message) { return JsonLine(record.channel, message) + "\n"; }, record.message);
}

}  // namespace

bool IsLcmLog(const std::filesystem::path& path) {
  try {
    std::array<char, kSyncWord.size()> begin{};
    const UniqueFd fd = OpenForReading(path);
    return read(fd.get(), begin.data(), begin.size()) == static_cast<ssize_t>(begin.size()) &&
           std::memcmp(begin.data(), kSyncWord.data(), begin.size()) == 0;
  } catch (const std::runtime_error&) {
    return false;
  }
}

void ConvertLog(const std::filesystem::path& log, const std::string& out, LogStream stream) {
  LcmLogReader reader(log);
  std::error_code unknown;
  if (std::filesystem::equivalent(log, out, unknown))
    throw std::runtime_error(out + " is the log itself, and would be lost; name another file");
  Output output(out);
  const bool csv = out.ends_with(".csv");
  const LogStream of_table = stream == LogStream::kAll ? LogStream::kPoses : stream;
  if (csv) output.Write(CsvHeaderOf(of_table));
  std::size_t messages = 0;
  std::size_t of_stream = 0;
  while (const auto record = reader.Next()) {
    ++messages;
    if (!IsOf(record->message, stream)) continue;
    output.Write(csv ? CsvText(*record, of_table) : JsonText(*record));
    ++of_stream;
  }
  if (messages > 0) output.Finish();
  if (reader.damaged())
    throw std::runtime_error(log.string() + " is cut off or damaged after " + std::to_string(messages) +
                             " messages of chequer's; those were written");
  if (messages == 0)
    throw std::runtime_error(log.string() + " holds no messages of chequer's, but " + std::to_string(reader.skipped()) +
                             " others");
  if (of_stream == 0)
    throw std::runtime_error(log.string() + " holds no messages of that --stream, but " + std::to_string(messages) +
                             " others of chequer's; chequerd sends robots where [robots] and tracks where [tracks] is "
                             "configured");
}

}  // namespace chequer
