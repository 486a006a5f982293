//! A tester that can't keep up reports the frames that it has lost: their place, and the total.

use crate::running::command;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Number of frames, more than the queues before a slow reader of the bus can hold.
const FRAMES: u64 = 400_000;

/// An adapter that sends [`FRAMES`] frames as fast as the program reads them, reports when all are sent, and then is
/// silent.
fn adapter() -> (String, mpsc::Receiver<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let bus = format!("slcan:tcp://{}", listener.local_addr().unwrap());
    let (sent, all_sent) = mpsc::channel();
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        // The connection ends with the program.
        let _ = flood(&mut stream, &sent);
    });
    (bus, all_sent)
}

fn flood(stream: &mut TcpStream, sent: &mpsc::Sender<()>) -> std::io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_millis(1)))?;
    let (mut begun, mut frames, mut bytes) = (false, 0, [0; 512]);
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(read) => {
                let commands = bytes[..read].split(|&byte| byte == b'\r');
                let commands: Vec<&[u8]> = commands.filter(|command| !command.is_empty()).collect();
                // Commands to open the channel, either normally or in listen-only mode.
                begun |= commands.iter().any(|command| matches!(command[0], b'O' | b'L'));
                stream.write_all(&vec![b'\r'; commands.len()])?;
            }
            Err(error) if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
        if begun && frames < FRAMES {
            stream.write_all(&b"t1812AABB\r".repeat(1_000))?;
            frames += 1_000;
            if frames == FRAMES {
                let _ = sent.send(());
            }
        }
    }
}

/// The number of lost frames in each message, and the total in the last line.
fn lost(stderr: &str) -> (Vec<u64>, u64) {
    let number = |line: &str, words: &str| {
        let before = line.split(words).next().filter(|before| before.len() < line.len())?;
        before.split(' ').next_back()?.parse::<u64>().ok()
    };
    let each =
        stderr.lines().filter_map(|line| line.split_once("the recorder lost ")?.1.split(' ').next()?.parse().ok());
    let each: Vec<u64> = each.collect();
    let all = stderr.lines().filter_map(|line| number(line, " frames were lost in all")).next_back();
    let sum = each.iter().sum();
    (each, all.unwrap_or(sum))
}

/// Reads the output of `monitor` only after all frames have been sent; then `monitor` runs to its end, or is
/// interrupted.
fn monitored(more: &[&str], interrupt: Option<fn(&Child) -> bool>) {
    let (bus, all_sent) = adapter();
    let args = [&["monitor", &bus], more].concat();
    let mut child = command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    all_sent.recv_timeout(Duration::from_secs(60)).unwrap();
    // Gives the frames that are still on their way time to arrive.
    std::thread::sleep(Duration::from_secs(1));
    if let Some(interrupt) = interrupt {
        assert!(interrupt(&child));
    }
    let (stdout, stderr) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let shown = AtomicU64::new(0);
    let (told, shown_before) = std::thread::scope(|scope| {
        let told = scope.spawn(|| {
            let (mut text, mut before) = (String::new(), None);
            for line in BufReader::new(stderr).lines() {
                before.get_or_insert(shown.load(Ordering::Relaxed));
                text += &format!("{}\n", line.unwrap());
            }
            (text, before)
        });
        BufReader::new(stdout).lines().for_each(|_| _ = shown.fetch_add(1, Ordering::Relaxed));
        told.join().unwrap()
    });
    let shown = shown.into_inner();
    assert!(child.wait().unwrap().success(), "{told}");
    let (each, all) = lost(&told);
    assert!(all > 0 && each.iter().sum::<u64>() == all, "{told}");
    assert_eq!(shown + all, FRAMES, "{shown} shown, {told}");
    if interrupt.is_none() {
        let before = shown_before.unwrap();
        assert!(before < shown / 2, "told after {before} of {shown} lines, while frames still wait: {told}");
    }
}

#[test]
fn a_monitor_that_falls_behind_accounts_for_every_frame() {
    monitored(&["--for", "20s"], None);
}

#[cfg(unix)] // a signal: `cargo xtask windows` presses Ctrl-C on a console
#[test]
fn an_interrupted_monitor_accounts_for_every_frame() {
    monitored(&[], Some(crate::running::interrupt));
}
