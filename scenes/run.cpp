#include "scenes/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "core/parallel.h"
#include "coupling/world.h"
#include "scenes/checkpoint.h"
#include "scenes/disk_estimate.h"
#include "scenes/effective_scene.h"
#include "scenes/folder_owner.h"
#include "scenes/machine.h"
#include "scenes/metrics.h"
#include "scenes/motion_output.h"
#include "scenes/output_queue.h"
#include "scenes/progress.h"
#include "scenes/rare_events.h"
#include "scenes/run_folder.h"
#include "scenes/run_record.h"
#include "scenes/scene_file.h"
#include "scenes/sha256.h"
#include "scenes/signals.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string hex(std::uint64_t value) {
  return fmt::format("{:016x}", value);
}

coupling::FrameReport initial_report(const coupling::World& world) {
  coupling::FrameReport report;
  report.frame = world.frame();
  report.time = world.time();
  return report;
}

/// One run of one scene into one folder.
class Run {
 public:
  Run(const RunOptions& options, Scene scene)
      : options_(options),
        scene_(std::move(scene)),
        folder_{output_folder(options, scene_)},
        identity_(scene_identity(scene_)),
        world_(std::make_unique<coupling::World>(scene_.world)) {
    record_.scene = scene_.name;
    record_.threads = thread_count();
    record_.scene_sha256 = sha256(identity_);
    record_.models = world_->models();
  }

  ExitCode execute() {
    const DiskEstimate disk = estimate_disk(*world_, scene_);
    require_disk(disk, folder_.root);
    make_folder(folder_.root);
    const FolderLock lock(folder_.root);
    folder_.require_free_names();
    const std::string text = effective_file(scene_, folder_.root);
    require_own_files(folder_, {scene_, options_.scene, text});
    record_.scene_file_sha256 = sha256(text);
    folder_.tidy();
    if (options_.restart) folder_.clear(scene_);
    changed_ = changed_settings(folder_.recorded_scene(), text);
    const bool resumed = resume();
    try {
      if (resumed && world_->frame() >= scene_.frames) return already_complete();
      if (!resumed) changed_.clear();
      for (const std::string& found : scene_.warnings) warn(found);
      for (const std::string& found : world_->warnings()) warn(found);
      const std::string shortage = disk_shortage(disk, scene_, resumed ? world_->frame() : 0, folder_.root);
      if (!shortage.empty()) warn(shortage);
      take_folder(text);
      if (!resumed) write_frame(initial_report(*world_), true);
      return compute();
    } catch (const std::exception& error) {
      fail(error);
      throw;
    }
  }

 private:
  /// Makes the folder the run's own. The record comes first and names the effective scene that follows: killed at
  /// any moment, a run leaves nothing that the next one would take for somebody else's.
  void take_folder(const std::string& scene_text) {
    const std::optional<RecordedRun> before = read_run_record(folder_.record());
    std::error_code ignored;  // write_file replaces what cannot be removed, or says why not
    if (before && before->scene_file_sha256 != record_.scene_file_sha256) fs::remove(folder_.scene(), ignored);
    keeper_.begin(record_);
    folder_.make(scene_);
    write_file(folder_.scene(), scene_text);
  }

  /// Goes on from the newest checkpoint that is whole, or from one before the first output that is damaged; false
  /// where there is no checkpoint.
  bool resume() {
    const std::vector<int> frames = checkpoint_frames(folder_.checkpoints());
    if (!resume_from(frames)) {
      require_no_other_run(folder_, record_.scene_sha256);
      return false;
    }
    const std::vector<DamagedOutput> damaged = damaged_outputs();
    if (damaged.empty()) return true;
    for (const DamagedOutput& output : damaged) record_.damaged_outputs.push_back(output.file);
    int first = damaged.front().frame;
    for (const DamagedOutput& output : damaged) first = std::min(first, output.frame);
    std::vector<int> before = frames;
    std::erase_if(before, [&](int frame) { return frame >= first; });
    const int reached = world_->frame();
    forget();
    if (resume_from(before)) {
      warn(fmt::format("outputs are missing or damaged and will be made again: {}", summary_of(damaged)));
    } else {
      warn(fmt::format(
          "outputs are missing or damaged: {}; no checkpoint is left from before frame {}, so they stay "
          "so (--restart makes all anew)",
          summary_of(damaged), first));
      std::vector<int> last = frames;
      std::erase_if(last, [&](int frame) { return frame > reached; });
      if (!resume_from(last)) throw std::runtime_error("a checkpoint that could be read cannot be read again");
    }
    outputs_.manifest.keep_up_to(world_->frame());
    return true;
  }

  /// What the manifest tells of the frames before the checkpoint; nothing where there is no manifest to tell.
  std::vector<DamagedOutput> damaged_outputs() {
    try {
      outputs_.manifest = Manifest::read(folder_.manifest());
    } catch (const std::exception& error) {
      warn(fmt::format("{} cannot be used ({}): earlier outputs are not verified", folder_.manifest().string(),
                       error.what()));
      return {};
    }
    outputs_.manifest.keep_up_to(world_->frame());
    return outputs_.manifest.damaged(folder_.root, [] { return stop_requested(); });
  }

  bool resume_from(const std::vector<int>& frames) {
    for (const int frame : frames) {
      const fs::path path = folder_.checkpoints() / checkpoint_name(frame);
      try {
        const Checkpoint checkpoint(path);
        require_same_run(folder_, checkpoint.header(), identity_);
        restore(checkpoint);
        return true;
      } catch (const Refusal& refusal) {
        if (refusal.code() == ExitCode::output_cannot_be_made) throw;
        skip_checkpoint(path, refusal.what());
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& error) {
        skip_checkpoint(path, error.what());
      }
    }
    return false;
  }

  void skip_checkpoint(const fs::path& path, const std::string& why) {
    warn(fmt::format("checkpoint {} cannot be used ({}); trying the one before", path.string(), why));
    forget();
  }

  /// Back to a world as the scene gives it: reading a checkpoint may have got half-way.
  void forget() {
    world_ = std::make_unique<coupling::World>(scene_.world);
    metrics_ = Metrics();
  }

  void restore(const Checkpoint& checkpoint) {
    checkpoint.read([&](StateVisitor& v) { metrics_.visit(v); }, [&](StateVisitor& v) { world_->visit(v); });
    world_->restored();
    if (world_->frame() != checkpoint.header().frame || world_->state_hash() != checkpoint.header().state_hash)
      throw std::runtime_error("it does not give back the state that it recorded");
    // What the last frame's outputs cost is known after its checkpoint: only the file that ended the run tells it.
    if (const Bytes ended = recorded_metrics(folder_); !ended.empty()) metrics_.recall_output_times(ended);
    last_checkpoint_ = world_->time();
    record_.frames = world_->frame();
    record_.state_hash = hex(metrics_.last_hash());
    record_.unconverged_solves = total_count(metrics_, "/unconverged_solves");
  }

  ExitCode already_complete() {
    if (!options_.quiet)
      say(stdout,
          fmt::format(
              "{} is complete: it has {} frames and {} were asked for (--frames for more, --restart to begin "
              "anew)\n",
              folder_.root.string(), world_->frame(), scene_.frames));
    if (!changed_.empty())
      warn(
          fmt::format("{}: nothing was computed with that, as the run is complete; --frames for more continues "
                      "with it, --restart "
                      "makes all frames anew",
                      fmt::join(changed_, "; ")));
    // A run killed between its last checkpoint and its record left the record behind; metrics may have been lost
    // since.
    const bool metrics_stand = !recorded_metrics(folder_).empty();
    if (!metrics_stand) write_metrics();
    write_motion();
    const std::optional<RecordedRun> recorded = read_run_record(folder_.record());
    if (recorded) record_.scene_file_sha256 = recorded->scene_file_sha256;
    const bool said_done = recorded && recorded->outcome == "done";
    if (!said_done || !metrics_stand || !record_.damaged_outputs.empty()) keeper_.write(record_, "done");
    return ExitCode::done;
  }

  ExitCode compute() {
    Progress progress(world_->frame(), scene_.frames, options_.quiet);
    if (world_->frame() > 1)
      progress.note(fmt::format("going on from frame {} in {}", world_->frame(), folder_.root.string()));
    if (!changed_.empty())
      progress.note(fmt::format("changed from frame {} on: {}", world_->frame() + 1, fmt::join(changed_, "; ")));
    while (world_->frame() < scene_.frames && !stop_requested()) {
      const auto start = Clock::now();
      coupling::FrameReport report =
          world_->step(1.0 / scene_.fps, [] { return stop_requested() || checkpoint_requested(); });
      if (!report.complete) {
        write_checkpoint();
        continue;
      }
      const auto stepped = Clock::now();
      write_frame(report, false);
      report.seconds["output"] = seconds_since(stepped);
      progress.frame(report, seconds_since(start));
    }
    const bool done = world_->frame() >= scene_.frames;
    finish_writing();
    if (done) write_motion();
    for (const std::string& text : rare_events(metrics_, world_->ledgers())) warn(text);
    keeper_.write(record_, done ? "done" : "checkpointed");
    progress.summary(keeper_.seconds(), outputs_.background_seconds());
    if (!options_.quiet)
      say(stdout,
          fmt::format("{}: {} frames in {}, state {}, last checkpoint in {:.2f} s{}\n", folder_.root.string(),
                      world_->frame(), seconds_text(keeper_.seconds()), record_.state_hash, record_.checkpoint_s,
                      done ? "" : "; stopped on request, the same command goes on"));
    return done ? ExitCode::done : ExitCode::checkpointed;
  }

  /// Checks the state, then hands everything that the frame writes to the writer's thread.
  void write_frame(const coupling::FrameReport& report, bool first) {
    const auto start = Clock::now();
    require_finite();
    const std::uint64_t hash = world_->state_hash();
    metrics_.add(metrics_row(*world_, report), hash);
    FrameOutput output = gather_outputs(*world_, scene_, folder_, record_.scene_sha256);
    outputs_.note_times(metrics_);
    metrics_.set(output.frame, output_timing, seconds_since(start));
    output.metrics = metrics_.file();
    const int frame = world_->frame(), every = scene_.output.checkpoint.every;
    const bool last = frame >= scene_.frames || stop_requested();
    const bool saved = first || last || (every > 0 && frame % every == 0) || take_checkpoint_request();
    if (saved) add_checkpoint(output);
    outputs_.submit(std::move(output));
    computed_ = true;
    output_seconds_ = seconds_since(start);
    metrics_.set(frame, output_timing, output_seconds_);
    record_.frames = frame;
    record_.state_hash = hex(hash);
    record_.unconverged_solves += report.unconverged_solves;
    if (saved) keeper_.write(record_, "running");
  }

  void add_checkpoint(FrameOutput& output) {
    const auto start = Clock::now();
    const CheckpointHeader header{world_->frame(), world_->time(), version, identity_, world_->state_hash()};
    output.checkpoint = make_checkpoint(
        header, [&](StateVisitor& v) { metrics_.visit(v); }, [&](StateVisitor& v) { world_->visit(v); });
    output.checkpoint_seconds = seconds_since(start);
    last_checkpoint_ = world_->time();
  }

  /// Saves the state as it is, in the middle of a frame too.
  void write_checkpoint() {
    require_finite();
    take_checkpoint_request();
    FrameOutput output;
    output.frame = world_->frame();
    add_checkpoint(output);
    outputs_.submit(std::move(output));
  }

  /// Waits for the writer; a stop that came after the last frame was handed over still gets its checkpoint.
  void finish_writing() {
    const auto start = Clock::now();
    if (last_checkpoint_ != world_->time()) write_checkpoint();
    outputs_.finish();
    record_.checkpoint_s = outputs_.checkpoint_seconds();
    outputs_.note_times(metrics_);
    output_seconds_ += seconds_since(start);
    if (computed_) metrics_.set(world_->frame(), output_timing, output_seconds_);
    write_metrics();
  }

  void write_metrics() {
    const Bytes bytes = metrics_.file();
    record_.metrics_sha256 = sha256(bytes);
    write_file(folder_.metrics(), bytes);
  }

  /// Joins what the frames recorded of the movement, once the writer's thread is done.
  void write_motion() {
    const std::vector<DamagedOutput> missing = join_motion(*world_, scene_, folder_, outputs_.manifest);
    if (!missing.empty()) warn(fmt::format("recorded motion has gaps: {}", summary_of(missing)));
  }

  void require_finite() {
    FiniteCheck check;
    world_->visit(check);
    if (check.first().empty()) return;
    throw Refusal(
        ExitCode::numerical_failure, "",
        fmt::format("the state is no longer finite in frame {} at {:.6g} s ({}) earlier frames and checkpoints "
                    "stay; try a finer step or softer material",
                    world_->frame(), world_->time(), check.first()));
  }

  void warn(const std::string& text) {
    record_.warnings.push_back(text);
    if (!options_.quiet) say(stderr, fmt::format("wick: warning: {}\n", text));
  }

  /// Leaves the reason behind.
  void fail(const std::exception& error) {
    try {
      outputs_.finish();
    } catch (const std::exception&) {
      // The error that is being reported already, or one that follows from it.
    }
    record_.checkpoint_s = outputs_.checkpoint_seconds();
    keeper_.fail(record_, error.what());
  }

  const RunOptions& options_;
  Scene scene_;
  RunFolder folder_;
  std::string identity_;
  std::unique_ptr<coupling::World> world_;
  std::vector<std::string> changed_;  ///< settings, since the folder's scene.json
  Metrics metrics_;
  RunRecord record_;
  RecordKeeper keeper_{folder_};
  bool computed_ = false;        ///< a frame, by this process
  double output_seconds_ = 0.0;  ///< that the simulation waited for the outputs of the last frame
  double last_checkpoint_ = -1;  ///< simulated time of the state that was saved last [s]
  OutputQueue outputs_{folder_, scene_.output};
};

}  // namespace

fs::path output_folder(const RunOptions& options, const Scene& scene) {
  return options.out.empty() ? fs::path("out") / scene.name : fs::path(options.out);
}

Scene load_scene(const RunOptions& options) {
  Scene scene = read_scene(options.scene, options.set);
  if (options.frames) scene.frames = *options.frames;
  const double end = (scene.frames - 1) / scene.fps;
  for (std::size_t n = 0; n < scene.world.heat_sources.size(); ++n)
    if (scene.world.heat_sources[n].start >= end)
      scene.warnings.push_back(
          fmt::format("/heat_sources/{}/start: the source has no effect (the last frame is at {:.4g} s)", n, end));
  return scene;
}

ExitCode run_scene(const RunOptions& options) {
  Scene scene = load_scene(options);
  require_memory(scene);
  watch_signals();
  std::optional<ThreadLimit> limit;
  if (options.threads > 0) limit.emplace(options.threads);
  return Run(options, std::move(scene)).execute();
}

}  // namespace wick::scenes
