#pragma once

#include <numbers>
#include <string>

#include "publish/messages.h"

namespace chequer {

inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

/// A number with so many digits behind the point, for people; what rounds to zero has no sign.
std::string FixedText(double number, int digits);
/// The same number, but for the sign of a zero.
inline double PlainZero(double number) { return number == 0 ? 0.0 : number; }

/// Direction of a marker's x axis in the x-y plane of the frame of reference, degrees from x towards y, −180..180: for
/// a camera that looks down on robots, their heading in the image. @pre marker.has_pose.
double HeadingDegrees(const MarkerPose& marker);

/// One line of JSON without its end. A frame: {"type": "poses", "channel", "camera", "frame", "sequence",
/// "captured_utc_us", "captured_monotonic_us", "instant", "published_utc_us", "published_monotonic_us",
/// "frames_dropped", "width", "height", "markers"}; markers as `chequer detect` prints them, with "size", "family" and
/// "center_px" and without "corners", which do not travel. What is not finite is null.
std::string JsonLine(const std::string& channel, const PosesMessage& message);
/// The status: {"type": "status", …} with the names of lcmtypes/status_t.lcm.
std::string JsonLine(const std::string& channel, const StatusMessage& message);

/// A line for people: when, where and what was seen.
std::string PlainLine(const PosesMessage& message);
std::string PlainLine(const StatusMessage& message);

/// The columns of CsvRows, with the line's end.
std::string CsvHeader();
/// One line a marker, each with its end; what is not known is empty. A frame without markers has one line without them.
std::string CsvRows(const std::string& channel, const PosesMessage& message);

/// A field of a line of comma-separated values, quoted where it must be.
std::string CsvField(const std::string& text);

}  // namespace chequer
