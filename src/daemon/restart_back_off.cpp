#include "daemon/restart_back_off.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/file.h"
#include "core/output_file.h"

namespace chequer {
namespace {

using std::chrono::seconds;

constexpr const char* kFile = "starts";
constexpr std::size_t kLongestFile = 100;
constexpr seconds kLongest{60};
/// A run that lasted this long was none of a series of failures.
constexpr seconds kForget{300};

}  // namespace

seconds DelayBeforeStart(const std::filesystem::path& folder, UtcTime now) {
  const std::filesystem::path file = folder / kFile;
  const std::int64_t now_s = std::chrono::duration_cast<seconds>(now.time_since_epoch()).count();
  std::int64_t count = 0;  // of starts in a row before this one
  std::int64_t last_s = 0;
  try {
    std::istringstream(ReadFile(file, kLongestFile)) >> count >> last_s;
  } catch (const std::runtime_error&) {
    // The first start, or a file that is not ours.
  }
  const std::int64_t doublings = std::clamp<std::int64_t>(count - 1, 0, 6);
  // The last start may itself have waited up to kLongest.
  if (count < 0 || last_s > now_s || now_s - last_s > (kForget + kLongest).count()) count = 0;
  try {
    WriteWithoutWaiting(file, std::to_string(count + 1) + " " + std::to_string(now_s) + "\n", Durability::kSynced);
  } catch (const std::runtime_error&) {
    return seconds(0);
  }
  return count == 0 ? seconds(0) : std::min(kLongest, seconds(std::int64_t{1} << doublings));
}

void ForgetFailures(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::remove(folder / kFile, ignored);
}

}  // namespace chequer
