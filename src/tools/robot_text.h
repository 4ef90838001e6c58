#pragma once

#include <string>

#include "publish/messages.h"

namespace chequer {

/// One line of JSON without its end: {"type": "robots", …} or {"type": "tracks", …} with "channel", the frame's times
/// and the names of lcmtypes/robot_pose_t.lcm and track_t.lcm. What is not finite is null; "floor" is left out where
/// there is no floor pose.
std::string JsonLine(const std::string& channel, const RobotsMessage& message);
std::string JsonLine(const std::string& channel, const TracksMessage& message);

/// A line for people: when, who, where, how fast.
std::string PlainLine(const RobotsMessage& message);
std::string PlainLine(const TracksMessage& message);

/// Comma-separated values: the names of the columns, and a line a robot; frames without any have one line with those
/// columns empty. Each ends with a line feed.
std::string RobotsCsvHeader();
std::string CsvRows(const std::string& channel, const RobotsMessage& message);
std::string TracksCsvHeader();
std::string CsvRows(const std::string& channel, const TracksMessage& message);

}  // namespace chequer
