#include "daemon/scheduling.h"

#include <pthread.h>
#include <sched.h>

#include <cstring>
#include <stdexcept>

namespace chequer {
namespace {

/// "0-3, 6": the processors this process may use.
std::string Text(const cpu_set_t& set) {
  std::string text;
  for (int first = 0; first < CPU_SETSIZE; ++first) {
    if (!CPU_ISSET(static_cast<unsigned>(first), &set)) continue;
    int last = first;
    while (last + 1 < CPU_SETSIZE && CPU_ISSET(static_cast<unsigned>(last + 1), &set)) ++last;
    text.append(text.empty() ? "" : ", ").append(std::to_string(first));
    if (last > first) text.append("-").append(std::to_string(last));
    first = last;
  }
  return text;
}

}  // namespace

void CheckCpus(const std::vector<int>& cpus) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;  // more processors than the set has room for
  for (const int cpu : cpus)
    if (cpu < 0 || cpu >= CPU_SETSIZE || !CPU_ISSET(static_cast<unsigned>(cpu), &allowed))
      throw std::runtime_error("pipeline.cpus: processor " + std::to_string(cpu) +
                               " is not there for chequerd; it may use " + Text(allowed));
}

int CpuOf(const SchedulingOptions& options, int worker, int thread, int workers) {
  const std::size_t cpus = options.cpus.size(), own = static_cast<std::size_t>(worker) % cpus,
                    cpu = static_cast<std::size_t>(worker + thread * workers) % cpus;
  return options.cpus[thread > 0 && cpu == own ? (own + 1) % cpus : cpu];
}

void BecomeHelper(const SchedulingOptions& options, int worker, int thread, int workers) {
  const std::string name = "chq-help" + std::to_string(worker) + "." + std::to_string(thread);
  pthread_setname_np(pthread_self(), name.c_str());
  if (!options.cpus.empty()) PinThisThread(CpuOf(options, worker, thread, workers));
  if (options.realtime_priority > 0) MakeThisThreadRealtime(options.realtime_priority);
}

std::string PinThisThread(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  return error == 0 ? std::string()
                    : "pinning to processor " + std::to_string(cpu) + " failed: " + std::strerror(error);
}

std::string MakeThisThreadRealtime(int priority) {
  sched_param parameter{};
  parameter.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  if (error == 0) return {};
  return "SCHED_FIFO with priority " + std::to_string(priority) + " was refused: " + std::strerror(error) +
         "; it needs LimitRTPRIO= and RestrictRealtime=no in the unit (realtime.conf, which the package brings, has "
         "both)";
}

}  // namespace chequer
