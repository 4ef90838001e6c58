#include "daemon/restart_back_off.h"

#include <algorithm>
#include <fstream>

namespace chequer {
namespace {

using std::chrono::seconds;

constexpr seconds kLongest{60};
/// A run that lasted this long was none of a series of failures.
constexpr seconds kForget{300};

}  // namespace

seconds DelayBeforeStart(const std::filesystem::path& folder, UtcTime now) {
  const std::filesystem::path file = folder / "starts";
  const std::int64_t now_s = std::chrono::duration_cast<seconds>(now.time_since_epoch()).count();
  std::int64_t count = 0;  // of starts in a row before this one
  std::int64_t last_s = 0;
  std::ifstream(file) >> count >> last_s;
  const std::int64_t doublings = std::clamp<std::int64_t>(count - 1, 0, 6);
  // The last start may itself have waited up to kLongest.
  if (count < 0 || last_s > now_s || now_s - last_s > (kForget + kLongest).count()) count = 0;
  std::ofstream(file, std::ios::trunc) << count + 1 << " " << now_s << "\n";
  return count == 0 ? seconds(0) : std::min(kLongest, seconds(std::int64_t{1} << doublings));
}

}  // namespace chequer
