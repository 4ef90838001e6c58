#pragma once

#include <CLI/CLI.hpp>

namespace chequer {

/// Exit statuses of `chequer`, the same for all commands.
inline constexpr int kExitOk = 0;
inline constexpr int kExitInput = 1;  ///< something given could not be read or used
inline constexpr int kExitUsage = 2;  ///< the command line itself is wrong

// One file a command. Each function adds its subcommand with its options and a callback that does the work, which main
// runs. The callback ends in one of three ways:
//   - it returns: status 0;
//   - it throws CLI::ValidationError(what is wrong and what would be right): status 2, printed by main;
//   - it throws any other std::exception: status 1, printed by main as `chequer COMMAND: message`. A command that has
//     already printed its messages (one a file) throws CLI::RuntimeError(kExitInput), for which main prints nothing.

/// `chequer calibrate`: the lens of a camera, and where it stands.
void AddCalibrateCommand(CLI::App& app);
/// `chequer cameras`: the cameras that are there, and what they can do.
void AddCamerasCommand(CLI::App& app);
/// `chequer convert`: recordings and images into each other, logs of poses into text.
void AddConvertCommand(CLI::App& app);
/// `chequer detect`: the markers in images.
void AddDetectCommand(CLI::App& app);
/// `chequer evaluate`: how exact a run along a straight track is.
void AddEvaluateCommand(CLI::App& app);
/// `chequer explain`: a picture of what the detector saw in an image.
void AddExplainCommand(CLI::App& app);
/// `chequer listen`: what arrives over LCM.
void AddListenCommand(CLI::App& app);
/// `chequer plan`: whether a camera will read markers, and how exactly.
void AddPlanCommand(CLI::App& app);
/// `chequer print`: sheets of markers to print.
void AddPrintCommand(CLI::App& app);
/// `chequer record`: the frames of any source as a recording.
void AddRecordCommand(CLI::App& app);
/// `chequer snapshot`: one frame of a camera as an image.
void AddSnapshotCommand(CLI::App& app);
/// `chequer render`: frames of markers as a camera would see them, written as a recording with truth.
void AddRenderCommand(CLI::App& app);
/// `chequer start`: from a new camera to poses in the room, step by step.
void AddStartCommand(CLI::App& app);
/// `chequer view`: a web page of what cameras and robots do.
void AddViewCommand(CLI::App& app);
/// `chequer status`: how the services fare that are heard over LCM.
void AddStatusCommand(CLI::App& app);

}  // namespace chequer
