//! Programs for the tests, written one instruction at a time.

// Every test binary uses its own part of this.
pub const RESETS: u32 = 0x4000_c000;
pub const PSM: u32 = 0x4001_0000;
pub const IO_BANK0: u32 = 0x4001_4000;
pub const UART0: u32 = 0x4003_4000;
pub const ADC: u32 = 0x4004_c000;
pub const TIMER: u32 = 0x4005_4000;
pub const WATCHDOG: u32 = 0x4005_8000;
pub const CLOCKS: u32 = 0x4000_8000;
pub const SIO: u32 = 0xd000_0000;
pub const NVIC_ISER: u32 = 0xe000_e100;
pub const AIRCR: u32 = 0xe000_ed0c;

/// Initial stack pointer of every program.
pub const STACK: u32 = 0x2004_0000;

/// Thumb instructions in the order they execute.
#[derive(Clone, Default)]
pub struct Program(pub Vec<u16>);

impl Program {
    pub fn new() -> Program {
        Program::default()
    }

    pub fn op(mut self, opcode: u16) -> Program {
        self.0.push(opcode);
        self
    }

    /// `register = value`, byte by byte.
    pub fn load(mut self, register: u16, value: u32) -> Program {
        let [first, rest @ ..] = value.to_be_bytes();
        self.0.push(0x2000 | register << 8 | u16::from(first));
        for byte in rest {
            self.0.push(0x0200 | register << 3 | register);
            self.0.push(0x3000 | register << 8 | u16::from(byte));
        }
        self
    }

    /// `[address] = value`, through r0 and r1.
    pub fn store(self, address: u32, value: u32) -> Program {
        self.load(0, address).load(1, value).op(0x6001)
    }

    /// `B .`
    pub fn hang(self) -> Program {
        self.op(0xe7fe)
    }

    /// `WFI` for ever.
    pub fn sleep(self) -> Program {
        self.op(0xbf30).op(0xe7fd)
    }

    /// `BX LR`
    pub fn bx_lr(self) -> Program {
        self.op(0x4770)
    }
}

/// Contents of flash: vector table, `main`, and handlers by exception number.
pub fn flash(main: Program, handlers: &[(usize, Program)]) -> Vec<u8> {
    const TABLE: usize = 0x100;
    const CODE: usize = 0x200;
    let mut flash = vec![0xff; CODE];
    let mut vector = |exception: usize, value: u32| {
        flash[TABLE + 4 * exception..][..4].copy_from_slice(&value.to_le_bytes());
    };
    vector(0, STACK);
    let mut code = Vec::new();
    for (exception, program) in std::iter::once(&(1, main)).chain(handlers) {
        vector(*exception, 0x1000_0001 + (CODE + 2 * code.len()) as u32);
        code.extend(&program.0);
    }
    flash.extend(code.iter().flat_map(|opcode: &u16| opcode.to_le_bytes()));
    flash
}

/// A segment of an ELF file: physical address and bytes.
pub type Segment<'a> = (u32, &'a [u8]);

/// A minimal ELF executable for ARM with these segments and absolute symbols.
pub fn elf(segments: &[Segment<'_>], symbols: &[(&str, u32)]) -> Vec<u8> {
    const HEADER: usize = 52;
    const PROGRAM_HEADER: usize = 32;
    let mut names = vec![0];
    let mut symbol_table = vec![0; 16];
    for (name, value) in symbols {
        words(&mut symbol_table, &[names.len() as u32, *value, 0]);
        halves(&mut symbol_table, &[0x10, 0xfff1]);
        names.extend(name.as_bytes());
        names.push(0);
    }
    let data_start = HEADER + PROGRAM_HEADER * segments.len();
    let data: Vec<u8> = segments.iter().flat_map(|(_, bytes)| *bytes).copied().collect();
    let symbols_start = data_start + data.len();
    let names_start = symbols_start + symbol_table.len();
    let sections_start = names_start + names.len();

    let mut file = vec![0x7f, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    halves(&mut file, &[2, 40]);
    words(&mut file, &[1, 0x1000_0201, HEADER as u32, sections_start as u32, 0x0500_0000]);
    halves(&mut file, &[HEADER as u16, PROGRAM_HEADER as u16, segments.len() as u16, 40, 3, 2]);
    let mut offset = data_start as u32;
    for (address, bytes) in segments {
        let size = bytes.len() as u32;
        words(&mut file, &[1, offset, *address, *address, size, size, 5, 4]);
        offset += size;
    }
    file.extend(data);
    file.extend(&symbol_table);
    file.extend(&names);
    words(&mut file, &[0; 10]);
    let symtab = [1, 2, 0, 0, symbols_start as u32, symbol_table.len() as u32, 2, 1, 4, 16];
    let strtab = [1, 3, 0, 0, names_start as u32, names.len() as u32, 0, 0, 1, 0];
    words(&mut file, &symtab);
    words(&mut file, &strtab);
    file
}

fn words(file: &mut Vec<u8>, values: &[u32]) {
    file.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

fn halves(file: &mut Vec<u8>, values: &[u16]) {
    file.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}
