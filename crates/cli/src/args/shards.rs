//! The arguments of `--shard` and of `pickline merge`.

use clap::Args;
use std::path::PathBuf;

/// A part of a call that is made in several processes or on several machines.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Shards")]
pub(crate) struct ShardArgs {
    /// Do only part I of N, such as 3/8, and write it to --shard-dir; `pickline merge` puts the
    /// parts together, byte for byte as the whole call. 0/N does in advance what all parts need
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Folder for the parts
    #[arg(long, value_name = "DIR", default_value = "shards", requires = "shard")]
    pub shard_dir: PathBuf,
}

/// Put the shards of a call together
///
/// Does what is left of a call whose parts were made with --shard, and prints and writes what the whole
/// call would have: the same bytes, however it was split. The call, with its output options, is in
/// the files of the shards; paths in it are those of the current folder. Merge only shards that you
/// trust, as they say which files are written.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  for i in 1 2 3 4; do pickline compare --cases dense --shard $i/4; done; pickline merge
  parallel pickline sweep --sweep robots --shard {}/8 ::: 1 2 3 4 5 6 7 8; pickline merge
  sbatch --array=1-100 --wrap 'pickline compare --shard $SLURM_ARRAY_TASK_ID/100'
  pickline merge shards/ --partial")]
pub(crate) struct MergeArgs {
    /// Files of shards, or folders with them
    #[arg(value_name = "SHARDS", default_value = "shards")]
    pub shards: Vec<PathBuf>,
    /// Go on without missing shards: cases, values or runs that are not complete are left out, and
    /// the result is marked as partial
    #[arg(long)]
    pub partial: bool,
    /// Overwrite files even if they are not results of the same verb
    #[arg(long)]
    pub force: bool,
}
