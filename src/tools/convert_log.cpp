#include "tools/convert_log.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <variant>

#include "publish/lcm_log.h"
#include "tools/message_text.h"

namespace chequer {
namespace {

/// The word before each event of a log.
constexpr std::array<unsigned char, 4> kSyncWord{0xed, 0xa1, 0xda, 0x01};

class Output {
 public:
  explicit Output(const std::string& path) : path_(path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "w")) {
    if (file_ == nullptr) throw std::runtime_error(path_ + " cannot be written: " + std::strerror(errno));
  }
  ~Output() {
    if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void Write(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) Fail();
  }
  /// Tells of a full disk, which shows only now.
  void Finish() {
    if (std::fflush(file_) != 0) Fail();
  }

 private:
  [[noreturn]] void Fail() const { throw std::runtime_error(path_ + " cannot be written: " + std::strerror(errno)); }

  std::string path_;
  std::FILE* file_;
};

void WriteCsv(const LogRecord& record, Output& output) {
  if (const auto* poses = std::get_if<PosesMessage>(&record.message)) output.Write(CsvRows(record.channel, *poses));
}

void WriteJson(const LogRecord& record, Output& output) {
  std::visit([&](const auto& message) { output.Write(JsonLine(record.channel, message) + "\n"); }, record.message);
}

}  // namespace

bool IsLcmLog(const std::filesystem::path& path) {
  std::array<char, kSyncWord.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), begin.size()) && std::memcmp(begin.data(), kSyncWord.data(), begin.size()) == 0;
}

void ConvertLog(const std::filesystem::path& log, const std::string& out) {
  LcmLogReader reader(log);
  Output output(out);
  const bool csv = out.ends_with(".csv");
  if (csv) output.Write(CsvHeader());
  std::size_t messages = 0;
  while (const auto record = reader.Next()) {
    csv ? WriteCsv(*record, output) : WriteJson(*record, output);
    ++messages;
  }
  output.Finish();
  if (reader.damaged())
    throw std::runtime_error(log.string() + " is cut off or damaged after " + std::to_string(messages) +
                             " messages of chequer's; those were written");
  if (messages == 0)
    throw std::runtime_error(log.string() + " holds no messages of chequer's, but " + std::to_string(reader.skipped()) +
                             " others");
}

}  // namespace chequer
