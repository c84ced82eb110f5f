//! Register offsets and bits of DW_apb_i2c.

/// Register offsets (4.3.17).
pub(super) const IC_CON: u32 = 0x00;
pub(super) const IC_TAR: u32 = 0x04;
pub(super) const IC_SAR: u32 = 0x08;
pub(super) const IC_DATA_CMD: u32 = 0x10;
pub(super) const IC_SS_SCL_HCNT: u32 = 0x14;
pub(super) const IC_SS_SCL_LCNT: u32 = 0x18;
pub(super) const IC_FS_SCL_HCNT: u32 = 0x1c;
pub(super) const IC_FS_SCL_LCNT: u32 = 0x20;
pub(super) const IC_INTR_STAT: u32 = 0x2c;
pub(super) const IC_INTR_MASK: u32 = 0x30;
pub(super) const IC_RAW_INTR_STAT: u32 = 0x34;
pub(super) const IC_RX_TL: u32 = 0x38;
pub(super) const IC_TX_TL: u32 = 0x3c;
pub(super) const IC_CLR_INTR: u32 = 0x40;
pub(super) const IC_CLR_RX_UNDER: u32 = 0x44;
pub(super) const IC_CLR_RX_OVER: u32 = 0x48;
pub(super) const IC_CLR_TX_OVER: u32 = 0x4c;
pub(super) const IC_CLR_RD_REQ: u32 = 0x50;
pub(super) const IC_CLR_TX_ABRT: u32 = 0x54;
pub(super) const IC_CLR_RX_DONE: u32 = 0x58;
pub(super) const IC_CLR_ACTIVITY: u32 = 0x5c;
pub(super) const IC_CLR_STOP_DET: u32 = 0x60;
pub(super) const IC_CLR_START_DET: u32 = 0x64;
pub(super) const IC_CLR_GEN_CALL: u32 = 0x68;
pub(super) const IC_ENABLE: u32 = 0x6c;
pub(super) const IC_STATUS: u32 = 0x70;
pub(super) const IC_TXFLR: u32 = 0x74;
pub(super) const IC_RXFLR: u32 = 0x78;
pub(super) const IC_SDA_HOLD: u32 = 0x7c;
pub(super) const IC_TX_ABRT_SOURCE: u32 = 0x80;
pub(super) const IC_DMA_CR: u32 = 0x88;
pub(super) const IC_DMA_TDLR: u32 = 0x8c;
pub(super) const IC_DMA_RDLR: u32 = 0x90;
pub(super) const IC_SDA_SETUP: u32 = 0x94;
pub(super) const IC_ENABLE_STATUS: u32 = 0x9c;
pub(super) const IC_FS_SPKLEN: u32 = 0xa0;
pub(super) const IC_CLR_RESTART_DET: u32 = 0xa8;
pub(super) const IC_COMP_PARAM_1: u32 = 0xf4;
pub(super) const IC_COMP_VERSION: u32 = 0xf8;
pub(super) const IC_COMP_TYPE: u32 = 0xfc;

/// IC_CON.
pub(super) const MASTER_MODE: u32 = 1 << 0;
pub(super) const MASTER_10_BIT: u32 = 1 << 4;
pub(super) const RESTART_EN: u32 = 1 << 5;
pub(super) const SLAVE_DISABLE: u32 = 1 << 6;
pub(super) const TX_EMPTY_CTRL: u32 = 1 << 8;

/// IC_DATA_CMD.
pub(super) const CMD_READ: u32 = 1 << 8;
pub(super) const CMD_STOP: u32 = 1 << 9;
pub(super) const CMD_RESTART: u32 = 1 << 10;

/// IC_RAW_INTR_STAT and its masks.
pub(super) const RX_UNDER: u32 = 1 << 0;
pub(super) const RX_OVER: u32 = 1 << 1;
pub(super) const RX_FULL: u32 = 1 << 2;
pub(super) const TX_OVER: u32 = 1 << 3;
pub(super) const TX_EMPTY: u32 = 1 << 4;
pub(super) const RD_REQ: u32 = 1 << 5;
pub(super) const TX_ABRT: u32 = 1 << 6;
pub(super) const RX_DONE: u32 = 1 << 7;
pub(super) const ACTIVITY: u32 = 1 << 8;
pub(super) const STOP_DET: u32 = 1 << 9;
pub(super) const START_DET: u32 = 1 << 10;
pub(super) const GEN_CALL: u32 = 1 << 11;
pub(super) const RESTART_DET: u32 = 1 << 12;

/// IC_ENABLE.
pub(super) const ENABLE: u32 = 1 << 0;
pub(super) const ABORT: u32 = 1 << 1;

/// IC_TX_ABRT_SOURCE.
pub(super) const ABRT_7B_ADDR_NOACK: u32 = 1 << 0;
pub(super) const ABRT_TXDATA_NOACK: u32 = 1 << 3;
pub(super) const ARB_LOST: u32 = 1 << 12;
pub(super) const ABRT_USER_ABRT: u32 = 1 << 16;
