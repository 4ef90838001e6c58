#pragma once

#include <string>
#include <vector>

#include "capture/aravis_handles.h"
#include "capture/camera_options.h"

// Features of GenICam: what they allow, and setting any of them by its name.

namespace chequer {

/// What a feature allows, such as "from 10 to 1000000", "true or false", "Off, Once or Continuous"; empty where it
/// does not say.
std::string AllowedByFeature(ArvDevice* device, const char* feature);

/// Sets any feature by its name, and runs it where it is a command. Returns what the camera made of the value where
/// that is another, empty where it is not. Throws CameraNotReady where the camera does not answer, and
/// std::runtime_error that says what is allowed.
std::string SetFeature(ArvDevice* device, const CameraSetting& setting);

/// "the camera made it 3.5", where that is off by more than a hundredth; empty where it is not.
std::string AlteredText(double wanted, double got);

/// The formats that a camera names, in its order.
std::vector<std::string> GenicamFormats(ArvCamera* camera);

/// What a trigger can come from.
std::vector<std::string> TriggerSources(ArvCamera* camera, ArvError& error);

/// "Off, Once or Continuous".
std::string JoinedWithOr(const std::vector<std::string>& words);

}  // namespace chequer
