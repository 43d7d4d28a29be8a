use std::process::Command;

use super::*;
use crate::model::worlds;

/// All that a file has: roads are the same if this is.
fn bytes(roads: &Roads) -> Vec<u8> {
    pack(roads, 0)
}

#[test]
fn roads_from_a_file_are_those_that_were_kept() {
    let folder = tempfile::tempdir().unwrap();
    for data in [worlds::porto(), worlds::streets(6, 5.0, true), worlds::cells(4)] {
        let world = data.view(1, 1);
        let roads = Roads::new(&world);
        for _ in 0..2 {
            let (kept, written) = Roads::kept(&world, folder.path());
            written.unwrap();
            assert_eq!(bytes(&kept), bytes(&roads));
            assert_eq!(
                (kept.edges(), kept.conflicts().len()),
                (roads.edges(), roads.conflicts().len())
            );
            assert_eq!(format!("{kept:?}"), format!("{roads:?}"));
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "one file each, and no drafts");
}

#[test]
fn a_file_that_is_there_is_used() {
    let (folder, data) = (tempfile::tempdir().unwrap(), worlds::cells(3));
    let world = data.view(1, 1);
    let mut roads = Roads::new(&world);
    roads.reservoirs[0] ^= true;
    let path = folder.path().join(format!("{PREFIX}{:032x}.bin", key(&world)));
    fs::write(path, pack(&roads, key(&world))).unwrap();
    assert_eq!(Roads::kept(&world, folder.path()).0.reservoirs, roads.reservoirs);
}

#[test]
fn a_pipe_in_the_place_of_a_file_keeps_nobody_waiting() {
    let (folder, data) = (tempfile::tempdir().unwrap(), worlds::cells(3));
    let world = data.view(1, 1);
    let path = folder.path().join(format!("{PREFIX}{:032x}.bin", key(&world)));
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    let (roads, written) = Roads::kept(&world, folder.path());
    written.unwrap();
    assert_eq!(bytes(&roads), bytes(&Roads::new(&world)));
    assert!(path.metadata().unwrap().is_file(), "it was replaced");
}

#[test]
fn a_damaged_file_is_noticed() {
    let data = worlds::cells(3);
    let world = data.view(1, 1);
    let whole = pack(&Roads::new(&world), key(&world));
    assert!(unpack(&world, key(&world), &whole).is_some());
    for index in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[index] ^= 1 << (index % 8);
        assert!(unpack(&world, key(&world), &damaged).is_none(), "byte {index}");
    }
    for length in 0..whole.len() {
        assert!(unpack(&world, key(&world), &whole[..length]).is_none(), "{length} bytes");
    }
    assert!(unpack(&world, key(&world) + 1, &whole).is_none(), "a file of another world");
}

/// The checksum is right: whoever writes such a file has a fault, but the manager goes on.
#[test]
fn a_file_with_impossible_numbers_is_not_used() {
    let data = worlds::cells(3);
    let world = data.view(1, 1);
    let (roads, key) = (Roads::new(&world), key(&world));
    let whole = pack(&roads, key);
    let content = &whole[..whole.len() - CHECKSUM_BYTES];
    let mut refused = 0;
    for word in (24..content.len()).step_by(4) {
        let mut changed = content.to_vec();
        changed[word..word + 4].copy_from_slice(&0x3fff_ffff_u32.to_le_bytes());
        changed.extend(xxh3_128(&changed).to_le_bytes());
        let Some(roads) = unpack(&world, key, &changed) else {
            refused += 1;
            continue;
        };
        let tracks = 0..roads.conflicts().tracks() as u32;
        let pairs: usize = tracks.map(|track| roads.conflicts().of(0, 0, track).count()).sum();
        assert_eq!(pairs, roads.conflicts().len());
        (0..roads.edges().len() as u32)
            .for_each(|edge| assert!(!roads.stops(0).closed_length(edge).is_nan()));
    }
    assert!(refused > roads.conflicts().len(), "{refused}: each pair names a track");
}

#[test]
fn what_roads_depend_on_is_in_the_key() {
    let data = worlds::cells(3);
    let before = key(&data.view(1, 1));
    assert_eq!(key(&data.view(2, 5)), before, "another run of the same world");
    let changes: [fn(&mut regatta_plugin::world::WorldData); 5] = [
        |data| data.robot_types[0].width += 0.01,
        |data| data.curves[0].control_points[1][0] += 0.01,
        |data| data.edges[0].reverse_speed += 0.1,
        |data| data.nodes[0].x += 0.01,
        |data| data.robot_types[0].max_rotation_speed = 1.0,
    ];
    for (number, change) in changes.iter().enumerate() {
        let mut data = data.clone();
        change(&mut data);
        assert_ne!(key(&data.view(1, 1)), before, "change {number}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_an_error_beside_the_roads() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let data = worlds::cells(3);
    let (roads, kept) = Roads::kept(&data.view(1, 1), &file.join("folder"));
    assert_eq!(bytes(&roads), bytes(&Roads::new(&data.view(1, 1))));
    let text = kept.unwrap_err().to_string();
    assert!(
        text.starts_with("can't keep the roads in ")
            && text.ends_with("use --no-cache")
            && !text.contains('\n'),
        "{text}"
    );
}

/// A disk that is full: needs a user who may mount one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_leaves_no_draft() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path();
    let mut mount = Command::new("mount");
    mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]);
    if !mount.arg(disk).output().is_ok_and(|output| output.status.success()) {
        println!("not tested: no disk can be mounted");
        return;
    }
    let kept = keep(disk, &disk.join("roads-1.bin"), &[0; 100_000]);
    let left = fs::read_dir(disk).unwrap().count();
    let unmounted = Command::new("umount").arg(disk).status();
    assert!(unmounted.is_ok_and(|status| status.success()));
    assert_eq!(kept.unwrap_err().kind(), std::io::ErrorKind::StorageFull);
    assert_eq!(left, 0);
}

#[test]
fn only_the_files_used_last_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = |number: usize| folder.path().join(format!("{PREFIX}{number}.bin"));
    let other = folder.path().join("other.txt");
    fs::write(&other, "").unwrap();
    for number in 0..MOST_FILES + 3 {
        keep(folder.path(), &path(number), b"roads").unwrap();
        let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(number as u64);
        File::options().append(true).open(path(number)).unwrap().set_modified(time).unwrap();
    }
    let left: Vec<usize> = (0..MOST_FILES + 3).filter(|number| path(*number).exists()).collect();
    assert_eq!(left, (3..MOST_FILES + 3).collect::<Vec<_>>());
    assert!(other.exists(), "files of others stay");
}
